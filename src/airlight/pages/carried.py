"""What a page carries of a frame: its linked programs, their bindings and resources, and the bytes of their uniforms.

The frame is prepared as one that is drawn here is, for the device of a page; ``Carried.plain`` is what the page's driver reads.
Nothing in it is made for one look: what a stage asks for is carried if the page has a way to make it, and refused otherwise.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..environment import Environment
from ..errors import StageError
from ..gpu.compute import layout_entry
from ..rendering.background import plain_background
from ..rendering.clips import pack_clips
from ..rendering.frame import Request, left_to_draw, prepare
from ..rendering.march import SKIN_VOXELS, MarchFrame, looked_at, program_key
from ..rendering.resources import pack_lights, pack_uniforms, uniform_values
from ..scene import Scene
from ..shader.layout import Struct, pack
from ..shader.program import (
    Binding,
    FrameUniforms,
    Program,
    ProgramKey,
    StageKey,
    Switches,
    build_program,
)
from ..stage import Grid, Resource, SlabTable, Stage, Table
from ..stages.camera import Orthographic, Perspective
from ..stages.transfer import ExactPreIntegrated, FastPreIntegrated, PostClassified, PreIntegrated
from ..transfer import TransferFunction
from ..transfer.tables import segment_rows
from .device import PageDevice
from .stored import Stored

ROWS: dict[type[Stage], str] = {
    PostClassified: "cells",
    FastPreIntegrated: "cells",
    PreIntegrated: "cells",
    ExactPreIntegrated: "pieces",
}
"""Transfer stages whose functions a page edits, and what their tables hold: cells, or what lies between control points."""
# What of a transfer stage's constants serves any function.
FOR_ANY = {"open_ends": True, "stepped_ends": True, "even": False}
USUAL = {"field": "linear", "gradient": "central", "lighting": "sampled", "visibility": "none", "shade": "blinn_phong"}


@dataclass(frozen=True, eq=False)
class Carried:
    """A scene of one stored volume, ready for a page."""

    frame: MarchFrame
    program: Program
    stored: Stored
    is_editable: bool

    @property
    def plain(self) -> dict[str, Any]:
        """Plain data for the page's driver."""
        frame, layer, volume = self.frame, self.frame.layers[0], self.stored.volume
        programs = {"march": self._plain_program(self.program)}
        tables = [r for _, r in self._resources() if isinstance(r, SlabTable)]
        if tables:
            programs["table"] = self._plain_program(table_program(tables[0]))
        low, high = (float(v) for v in (volume.array.min(), volume.array.max()))
        background = plain_background(frame.scene)
        return {
            "camera": _plain_camera(frame.given.camera),
            "size_px": list(frame.size_px),
            "anchor_world": frame.anchor_world.tolist(),
            "corners_world": volume.corners_world(layer.field.cells).tolist(),
            "step_world": frame.step_world,
            "background": None if background is None else list(background),
            "units": volume.units,
            "value_unit": volume.value_unit,
            "volume": {
                "size": list(volume.size),
                "bits": self.stored.bits,
                "format": self.stored.encoding.format,
                "scale": self.stored.encoding.scale,
                "offset": self.stored.encoding.offset,
                "range": [low, high],
            },
            "programs": programs,
            "transfer": _plain_function(layer.context.transfer) if self.is_editable else None,
        }

    def _resources(self) -> list[tuple[Binding, Resource | None]]:
        return [(binding, resource_of(self.frame, binding)) for binding in self.program.bindings]

    def _plain_program(self, program: Program) -> dict[str, Any]:
        x, y = program.key.group_px
        is_march = program is self.program
        return {
            "wgsl": without_comments(program.linked.text),
            "group_px": [x, y],
            "layout": plain_struct(program.uniforms),
            "uniforms": in_text(self.uniform_bytes() if is_march else bytes(program.uniforms.dtype.itemsize)),
            "bindings": [
                {
                    "group": one.group,
                    "entry": _in_camel(layout_entry(self.frame.device, one)),
                    "name": one.name,
                    "holds": self._plain_resource(one) if is_march else {"kind": one.kind},
                }
                for one in program.bindings
            ],
        }

    def _plain_resource(self, binding: Binding) -> dict[str, Any]:
        """What the page makes of a binding: of its name, or of what lies beside it."""
        layer = self.frame.layers[0]
        own = self.is_editable and binding.owner[0] == "transfer"
        match resource_of(self.frame, binding):
            case Grid():
                return {"kind": "volume"}
            case Table() if own:
                return {"kind": "function", "rows": ROWS[type(layer.stages["transfer"])]}
            case Table(texels):
                depth, height, width, _ = texels.shape
                return {"kind": "table", "size": [width, height, depth], "texels": in_text(texels.tobytes())}
            case SlabTable() as table:
                rows = {} if own else {"rows": in_text(segment_rows(table.function, table.entries).tobytes())}
                told = {name: getattr(table, name) for name in ("entries", "lengths", "length", "weighted")}
                return {"kind": "slabs", "associated": table.function.associated, **told, **rows}
        if binding.name == "lights":
            return {"kind": "bytes", "bytes": in_text(pack_lights(self.frame.scene.lights))}
        if binding.name == "clips":
            world_from_device = np.eye(4)
            world_from_device[:3, 3] = self.frame.anchor_world
            return {"kind": "bytes", "bytes": in_text(pack_clips(self.frame.clip_groups, world_from_device, ()))}
        return {"kind": {"uniforms": "uniforms", "radiance": "radiance", "depth": "depth"}.get(binding.name, binding.kind)}

    def uniform_bytes(self) -> bytes:
        """Bytes of all uniforms, as the first picture has them."""
        frame = self.frame
        return pack_uniforms(self.program, frame_uniforms(frame), _values(frame))


def carried(scene: Scene, stored: Stored, size_px: tuple[int, int], driver: Stage, step: float) -> Carried:
    """Gather what a page needs of a resolved scene whose layer shows the stored volume.

    Raises
    ------
    StageError
        Names what a page cannot draw.
    """
    device: Any = PageDevice(stored.encoding)
    frame = _prepared(device, scene, size_px, driver, step)
    check_frame(frame)
    is_editable = (
        is_plain(scene.visible_layers[0].function)
        and type(frame.layers[0].stages["transfer"]) in ROWS
        and _stays(frame, device, driver, step)
    )
    program = build_program(page_key(frame, is_editable))
    found = Carried(frame, program, stored, is_editable)
    for binding, resource in found._resources():
        check_resource(binding, resource, frame.stages_of(frame.layers[0]))
    _check_camera(frame, device, driver, step)
    return found


def is_plain(function: Any) -> bool:
    """Whether a function has nothing but control points."""
    return type(function) is TransferFunction and not function.surfaces


def page_key(frame: MarchFrame, is_editable: bool) -> ProgramKey:
    """Key of the march for a page; that of a function which is edited serves any other.

    Space is skipped by what samples tell: blocks are known for one function alone.
    """
    key = _own_key(frame)
    skips = bool(getattr(frame.scene_stages["integrate"], "skips_empty", False)) and is_editable
    key = replace(key, switches=replace(key.switches, skips_empty=skips))
    if not is_editable:
        return key

    def for_any(one: StageKey) -> StageKey:
        return replace(one, statics=tuple((name, FOR_ANY.get(name, value)) for name, value in one.statics))

    return replace(
        key, layers=tuple(tuple((s, for_any(k) if s == "transfer" else k) for s, k in layer) for layer in key.layers)
    )


def _own_key(frame: MarchFrame) -> ProgramKey:
    root, outputs = frame.scene_stages["driver"].wgsl, ("radiance", "depth", *looked_at(frame))
    return program_key(frame, root, outputs)


def table_program(table: SlabTable) -> Program:
    """Program that fills a table of slabs on the page's device."""
    outputs = ("segments", "waiting", "slab_table_out")
    switches = Switches(weighted=table.weighted)
    return build_program(ProgramKey("passes/slab_table.wgsl", (), (), outputs, ("slab_table",), switches, PageDevice.traits))


def frame_uniforms(frame: MarchFrame) -> FrameUniforms:
    """Return the frame's own uniforms for the whole image."""
    width, height = frame.size_px
    return FrameUniforms(
        size_px=(width, height),
        tile_size_px=(width, height),
        band_rows=height,
        step_world=frame.step_world,
        t_offset_world=frame.t_offset_world,
        skin_world=SKIN_VOXELS * min(frame.layers[0].context.volume.spacing),
        change_slots=1,
    )


def resource_of(frame: MarchFrame, binding: Binding) -> Resource | None:
    """What a stage asked for under a binding; None for what is not a stage's."""
    slot, index, name = binding.owner
    if not slot or binding.kind == "sampler":
        return None
    return (frame.scene_resources if index is None else frame.layers[index].resources)[slot][name]


def plain_struct(struct: Struct) -> dict[str, Any]:
    """Names, types and places of a struct's members, as plain data."""
    members = [
        {"name": m.name, "type": m.type, "offset": m.offset} | ({"struct": plain_struct(m.struct)} if m.struct else {})
        for m in struct.members
    ]
    return {"name": struct.name, "size": struct.size, "members": members}


def without_comments(wgsl: str) -> str:
    """WGSL without what is not code: comments name files, those of stages from outside with their folders."""
    code = re.sub(r"//[^\n]*|/\*.*?\*/", "", wgsl, flags=re.DOTALL)
    return "".join(f"{line.rstrip()}\n" for line in code.splitlines() if line.strip())


def in_text(data: bytes) -> str:
    """Bytes as base64."""
    return base64.b64encode(data).decode("ascii")


# -- what cannot be carried


def check_scene_for_page(scene: Scene) -> None:
    """Refuse, before anything is computed, what a page has no pass for.

    Raises
    ------
    StageError
        Names it.
    """
    visible = scene.visible_layers
    if len(visible) != 1:
        raise StageError("scene.layers", f"has {len(visible)} visible layers, and a page draws one", "hide the others")
    layer = visible[0]
    if layer.labels is not None:
        raise StageError("layer.labels", "are given, and a page draws volumes without labels", "leave them out")
    if len(layer.channels) > 1:
        raise StageError(
            "layer.transfer", f"shows {len(layer.channels)} channels, and a page carries one", "choose one channel"
        )
    if scene.meshes:
        raise StageError("scene.meshes", f"are {len(scene.meshes)}, and a page draws no meshes", "leave them out")
    if isinstance(scene.background, Environment):
        raise StageError("scene.background", "is an environment, and a page has a plain one", "give a colour")
    if any(clip.kind == "mesh" for clip in scene.clips_of(layer)):
        raise StageError("scene.clips", "hold a mesh, and a page cuts by planes, boxes and spheres", "leave it out")
    if scene.annotations:
        raise StageError("scene.annotations", "are marks on one picture, and a page draws many", "leave them out")
    camera = scene.camera
    if not isinstance(camera, Perspective | Orthographic):
        raise StageError(
            f"camera {getattr(camera, 'name', camera)!r}", "cannot be turned on a page", "use perspective or orthographic"
        )


def check_frame(frame: MarchFrame) -> None:
    """Refuse what needs passes that a page does not have.

    Raises
    ------
    StageError
        Names the stage.
    """
    driver, tone = frame.scene_stages["driver"], frame.scene_stages["tone"]
    if driver.name != "march":
        raise StageError(f"driver {driver.name!r}", "draws in passes, and a page marches", "use driver='march'")
    if frame.tones_late:
        raise StageError(
            f"look.tone {tone.name!r}", "looks at the whole picture first, and a page at pixels", "use tone='linear'"
        )


def check_resource(binding: Binding, resource: Resource | None, stages: Mapping[str, Stage]) -> None:
    """Refuse what a page has no way to make.

    Raises
    ------
    StageError
        Names slot and stage.
    """
    slot = binding.owner[0]
    is_grid = type(resource) is Grid and not (resource.levels or resource.masked)
    if resource is None or is_grid or isinstance(resource, Table | SlabTable):
        return
    what = "levels of the grid" if isinstance(resource, Grid) else f"the resource {type(resource).__name__}"
    raise StageError(f"look.{slot} {stages[slot].name!r}", f"asks for {what}, which a page does not make", instead_of(slot))


def instead_of(slot: str) -> str:
    """What to do where a page cannot draw the stage of a slot."""
    return f"use {slot}={USUAL[slot]!r}" if slot in USUAL else "choose another, or send a picture: airlight render"


def _check_camera(frame: MarchFrame, device: Any, driver: Stage, step: float) -> None:
    """Refuse stages whose parameters follow the camera, which the page's driver does not know."""
    camera: Any = frame.given.camera
    away = tuple(2 * e - t for e, t in zip(camera.eye, camera.target, strict=True))
    width, height = frame.size_px
    moved = _prepared(device, replace(frame.given, camera=replace(camera, eye=away)), (2 * width, height + 1), driver, step)
    for name in _different(frame, moved):
        if name not in ("frame", "camera"):
            slot = name.removesuffix("_0")
            raise StageError(f"look.{slot}", "follows the camera, which a page moves by itself", instead_of(slot))


def _stays(frame: MarchFrame, device: Any, driver: Stage, step: float) -> bool:
    """Whether nothing but the transfer stage looks at the transfer function."""
    scene = frame.given
    layer = scene.visible_layers[0]
    function: Any = layer.transfer
    points = [(1.25 * v + 0.25, (0.5, 0.25, 0.125), 0.5 * e) for v, _, e in function.points]
    other = replace(layer, transfer=TransferFunction(points, function.associated))
    layers = tuple(other if one is layer else one for one in scene.layers)
    return not set(_different(frame, _prepared(device, replace(scene, layers=layers), frame.size_px, driver, step))) - {
        "transfer_0"
    }


def _different(frame: MarchFrame, other: MarchFrame) -> list[str]:
    """Names of the members of the uniform struct, and of slots with tables, that two frames of one program do not share."""
    mine, others = _values(frame), _values(other)
    program = build_program(_own_key(frame))
    told = []
    for member in program.uniforms.members:
        if member.name not in mine or member.struct is None:
            continue
        if pack(member.struct, mine[member.name]) != pack(member.struct, others.get(member.name)):
            told.append(member.name)
    for slot, resources in frame.layers[0].resources.items():
        for name, one in resources.items():
            two = other.layers[0].resources[slot].get(name)
            same = np.array_equal(one.texels, two.texels) if isinstance(one, Table) and isinstance(two, Table) else True
            if slot != "transfer" and (type(one) is not type(two) or not same):
                told.append(f"{slot}_0")
    return told


def _prepared(device: Any, scene: Scene, size_px: tuple[int, int], driver: Stage, step: float) -> MarchFrame:
    request = Request(size_px, driver, step, skip="none")
    scene, reason = left_to_draw(scene)
    if reason:
        raise StageError("scene", f"shows nothing: {reason}", "see --clip and --crop")
    return prepare(device, scene, request, lambda: None, lambda *_: None)


def _values(frame: MarchFrame) -> dict[str, Any]:
    return uniform_values(frame.device, frame.scene_stages, frame.layers, frame.anchor_world, frame.progress)


def _plain_camera(camera: Any) -> dict[str, Any]:
    own = "height" if isinstance(camera, Orthographic) else "fov_deg"
    vectors = {name: list(getattr(camera, name)) for name in ("eye", "target", "up")}
    return {"name": camera.name, **vectors, own: getattr(camera, own)}


def _plain_function(function: Any) -> dict[str, Any]:
    return {"points": [[v, list(rgb), e] for v, rgb, e in function.points], "associated": function.associated}


def _in_camel(entry: Mapping[str, Any]) -> dict[str, Any]:
    """A layout entry by the names that browsers use."""

    def camel(name: str) -> str:
        first, *rest = name.split("_")
        return first + "".join(word.title() for word in rest)

    return {camel(key): _in_camel(value) if isinstance(value, Mapping) else value for key, value in entry.items()}
