"""The half-angle driver: a sweep for each light, in which the light and the eye take turns from group to group of slices.

Before a group is drawn for the eye, each texel of the light's buffer carries its light on through the group, along its own ray:
the same slabs, classified by the same stages, with another integrate stage. Two buffers in turn hold the light at the group's
first and last plane; the visibility stage mixes them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..clips import Solid
from ..errors import StageError, ValueRangeError
from ..gpu import compute, light_buffers, raster
from ..handed import COLOUR, DEPTH, PIXEL_BYTES
from ..light import Light
from ..scene import Layer, Scene
from ..shader.program import (
    FrameUniforms,
    GroupUniforms,
    LampUniforms,
    PlaneUniforms,
    Program,
    ProgramKey,
    Switches,
    build_program,
)
from ..stage import Stage
from ..stages.camera import Camera, Orthographic, Perspective
from ..stages.driver_half_angle import HalfAngle, HalfAngleSweep, check_ways, half_angle_planes, ways_from
from ..stages.driver_slices import Planes
from ..stages.lighting import Quantised, Sampled, Unlit
from ..stages.shade import NoShade
from ..stages.tone import Linear
from ..stages.transport import Dark, Passed, Transmittance
from ..stages.view_rays import least_cosine
from ..stages.visibility import NoOcclusion
from ..volume import FloatArray
from .light_views import MARGIN_TEXELS, clip_from_world, is_parallel, light_camera, picture_from_world, way_of
from .march import Band, MarchFrame, bound_groups, looked_at, uploaded, with_blocks, written_clips
from .nearby import near_camera, shifted
from .proxies.pieces import Pieces, pieces_between
from .proxies.polyhedra import Polyhedron, inflated
from .rasterised import depths_between
from .resources import DrawnLayer, pack_uniforms
from .sweep import corners_of, draw_groups, hull_of, numbers_of, planes_of, shown_in, slice_statistics, sweep_program

WHERE = "driver 'half_angle'"
KEPT_SLICES = 48  # room is made for multiples of so many slices, so that few lights ask for more
UNTOUCHED = -1.0  # as wgsl/light_kept.wgsl has it


def check_lit(frame: MarchFrame) -> None:
    """Refuse what this driver cannot draw.

    Raises
    ------
    StageError
        For scenes whose light it does not know, and what would cast shadows but is not in the volume.
    """
    camera, integrate = frame.scene_stages["camera"], frame.scene_stages["integrate"]
    if not isinstance(camera, (Perspective, Orthographic)):
        raise StageError(WHERE, f"draws no {camera.name} images", 'use driver="march"')
    if not (getattr(integrate, "uses_slabs", False) and hasattr(integrate, "opaque_at")):
        raise StageError(WHERE, f"lets light through slabs, and {integrate.name} has none", 'use driver="march"')
    for layer in frame.layers:
        visibility = frame.stages_of(layer)["visibility"]
        if not isinstance(visibility, NoOcclusion):
            raise StageError(
                WHERE, f"tells itself what reaches a place, and so does {visibility.name}", 'use visibility="none"'
            )
    if any(isinstance(layer.stages["lighting"], Quantised) for layer in frame.layers):
        raise StageError(WHERE, "lights places, and lighting quantised directions alone", 'use lighting="sampled"')
    if not frame.scene.lights:
        raise StageError(WHERE, "makes shadows of lights, and there are none", 'add lights, or use driver="slices"')
    shades = [layer.stages["shade"] for layer in frame.layers]
    if not any(getattr(shade, "asks_lights", True) for shade in shades):
        raise StageError(
            WHERE, f"makes shadows of lights, and shade {shades[0].name} asks none", 'use shade="phase" or "blinn_phong"'
        )
    if frame.scene.meshes:
        raise StageError(WHERE, "knows no shadows of meshes", 'leave them out, or use driver="march"')
    if any(isinstance(clip, Solid) for clip in frame.clips):
        raise StageError(WHERE, "knows no meshes that clip", 'clip by planes, boxes or spheres, or use driver="march"')


def check_pictures(scene: Scene, driver: Stage) -> None:
    """Refuse lights that throw pictures where nothing throws them.

    Raises
    ------
    StageError
        Names the light.
    """
    for number, light in enumerate(scene.lights):
        if light.beam is not None and not getattr(driver, "throws_pictures", False):
            what = f"is a spot light, and the driver {driver.name!r} throws no pictures"
            raise StageError(f"scene.lights[{number}]", what, 'use driver="half_angle", or Light.point')


# -- one sweep for each light


@dataclass(frozen=True, eq=False)
class Lamp:
    """A light of the scene, in the user's world and in the device's, with the slices that suit it."""

    number: int
    given: Light
    light: Light
    planes: Planes
    is_opposite: bool


def lamps_of(
    scene: Scene, camera: Camera, size_px: tuple[int, int], corners_world: FloatArray, step_world: float
) -> list[Lamp]:
    """Lights with their slices, in the user's world, for a volume with these corners (n, 3).

    Raises
    ------
    ValueRangeError
        When a light is in the volume, or the eye among the slices.
    """
    middle, found = corners_world.mean(axis=0), []
    to_eye = -way_of(Light.head(), camera, middle)
    for number, light in enumerate(scene.lights):
        planes, is_opposite = half_angle_planes(-way_of(light, camera, middle), to_eye, middle, step_world)
        lamp = Lamp(number, light, light, planes, is_opposite)
        cosines = cosines_of(lamp, camera, size_px, corners_world)
        # An eye in the very middle is not on any side of it.
        check_ways(planes, min(cosines[0], -float(planes.normal @ to_eye)), cosines[1], number)
        found.append(lamp)
    return found


def cosines_of(lamp: Lamp, camera: Camera, size_px: tuple[int, int], corners_world: FloatArray) -> tuple[float, float]:
    """Least cosine between the normal of a light's planes and rays of the eye, and those of the light, in its direction."""
    light, middle = lamp.given, corners_world.mean(axis=0)
    place: Any = way_of(light, camera, middle)[None] if is_parallel(light, camera) else None
    if place is None:
        place = np.asarray(camera.eye if light.kind == "head" else light.vector, dtype=np.float64)
    way = -1.0 if lamp.is_opposite else 1.0
    of_light = float((way * ways_from(place, corners_world) @ lamp.planes.normal).min())
    return least_cosine(lamp.planes.normal, camera, size_px, corners_world), of_light


def longest_way(driver: Stage, layers: Sequence[Layer], scene: Scene, size_px: tuple[int, int], step_world: float) -> float:
    """Length of the longest slab of all sweeps [world], of the eye's rays and of the lights', or a bit more.

    A power of the root of two, in steps: tables of slabs stay as they are while lights and camera turn.
    """
    corners = np.concatenate([layer.volume.corners_world(bool(getattr(layer.look.field, "cells", False))) for layer in layers])
    camera, longest = scene.camera, step_world
    if not isinstance(camera, (Perspective, Orthographic)):
        return step_world
    for lamp in lamps_of(scene, camera, size_px, corners, step_world):
        longest = max(longest, lamp.planes.spacing_world / min(cosines_of(lamp, camera, size_px, corners)))
    halves = math.ceil(2 * math.log2(longest / step_world) - 1e-9)
    return step_world * math.sqrt(2) ** halves


def sweeps_of(frame: MarchFrame) -> list[tuple[MarchFrame, Carried]]:
    """What the eye sees of each light, and the light beside it."""
    check_lit(frame)
    driver, camera = frame.scene_stages["driver"], frame.layers[0].context.camera
    assert isinstance(driver, HalfAngle)
    return [
        sweep_of(frame, driver, replace(lamp, light=frame.scene.lights[lamp.number]))
        for lamp in lamps_of(frame.given, camera, frame.size_px, corners_of(frame), frame.step_world)
    ]


def sweep_of(frame: MarchFrame, driver: HalfAngle, lamp: Lamp) -> tuple[MarchFrame, Carried]:
    """Frame of the eye for one light, and that light."""
    sweep = HalfAngleSweep(
        curved=driver.curved,
        refine=driver.refine,
        back_to_front=lamp.is_opposite,
        group=driver.slices_at_once,
        given=lamp.planes,
    )
    stages = {
        **frame.scene_stages,
        "driver": sweep,
        "visibility": Passed(driver.transport.is_grey),
        "transport": driver.transport,
    }
    layers = frame.layers if lamp.number == 0 else tuple(map(lit_alone, frame.layers))
    eye = replace(frame, scene=replace(frame.scene, lights=(lamp.light,)), scene_stages=stages, layers=layers)
    return eye, Carried(eye, light_frame(eye, lamp, driver), lamp, driver)


def light_frame(frame: MarchFrame, lamp: Lamp, driver: HalfAngle) -> MarchFrame:
    """Frame of a light that sees what the eye sees: rays that find out what comes through."""
    size = (driver.light_size, driver.light_size)
    # The same light whatever is skipped.
    known = replace(frame, layers=tuple(with_blocks(layer, frame.scene_stages["integrate"]) for layer in frame.layers))
    camera = light_camera(lamp.given, frame.layers[0].context.camera, shown_in(known), driver.light_size, lamp.number)
    if isinstance(camera, Orthographic):
        eye, target = (shifted(point, frame.anchor_world) for point in (camera.eye, camera.target))
        near: Camera = replace(camera, eye=eye, target=target)
    else:
        try:
            near, _ = near_camera(camera, frame.anchor_world, frame.layers[0], frame.step_world)
        except ValueRangeError as error:
            raise ValueRangeError(f"scene.lights[{lamp.number}]", error.what, "use Light.directional") from None
    kept = Transmittance(driver.transport.is_grey)
    stages = {**frame.scene_stages, "camera": near, "integrate": kept, "visibility": NoOcclusion(), "tone": Linear()}
    layers = tuple(unlit(layer, size) for layer in frame.layers)
    return replace(frame, scene_stages=stages, layers=layers, size_px=size, t_offset_world=0.0, passes=())


def unlit(layer: DrawnLayer, size_px: tuple[int, int]) -> DrawnLayer:
    """Return the layer without light, as a camera of another image sees it."""
    shaded = shaded_by(layer, NoShade(), Unlit())
    return replace(shaded, context=replace(layer.context, size_px=size_px))


def lit_alone(layer: DrawnLayer) -> DrawnLayer:
    """Return the layer without light of its own: what glows counts once, with the first light."""
    return layer if getattr(layer.stages["shade"], "lit", True) else shaded_by(layer, Dark(), Sampled(at="front"))


def shaded_by(layer: DrawnLayer, shade: Stage, lighting: Stage) -> DrawnLayer:
    """Return the layer with other stages for light, which need no resources."""
    stages = {**layer.stages, "shade": shade, "lighting": lighting}
    return replace(layer, stages=stages, resources={**layer.resources, "shade": {}, "lighting": {}})


@dataclass(eq=False)
class Carried:
    """A light beside the sweep of an eye: it is carried on through each group before that is drawn; see ``sweep.Beside``.

    Light is as many slices behind as the driver's bias tells: what the eye finds at a slice is what arrives there.
    """

    eye: MarchFrame
    frame: MarchFrame
    lamp: Lamp
    driver: HalfAngle
    extra: tuple[str, ...] = ("lamp",)
    ends: list[tuple[int, int]] = field(default_factory=list)
    planes: Planes = field(init=False)
    program: Program = field(init=False)
    pipeline: compute.Pipeline = field(init=False)
    pieces: Pieces = field(init=False)
    part: FrameUniforms = field(init=False)
    depths: tuple[float, float] = field(init=False)
    corners: Any = field(init=False)
    buffers: tuple[Any, Any] = field(init=False)
    kept: Any = field(init=False)
    values: dict[str, Any] = field(init=False)
    groups: list[Any] = field(init=False)

    @property
    def thrown(self) -> tuple[str, ...]:
        """What is looked at where the light throws a picture."""
        return () if self.lamp.light.beam is None else ("light_picture",)

    @property
    def outputs(self) -> tuple[str, ...]:
        """What the eye's program looks at."""
        return ("light_planes", *self.thrown)

    def begin(self, planes: Planes | None, ends: Sequence[tuple[int, int]]) -> dict[str, Any]:
        """Take note of planes and groups; make ready what the light needs."""
        assert planes is not None
        frame, device = self.frame, self.frame.device
        # Light passes the planes with the eye or against it.
        turned = replace(planes, normal=-planes.normal, first=-planes.first) if self.lamp.is_opposite else planes
        self.planes, self.ends = turned, [(-end, -begin) if self.lamp.is_opposite else (begin, end) for begin, end in ends]
        with frame.clock("link and compile"):
            outputs = ("light_before", "light_planes_out", *looked_at(frame), *self.thrown)
            self.program = frame.program("light_slices.wgsl", outputs, ("group", "planes", "lamp"))
            self.pipeline = raster.sweep_pipeline(device, self.program, light_buffers.LIGHT_FORMAT)
        with frame.clock("proxies"):
            self.pieces = self._pieces()
            self.corners = raster.write_corners(device, "corners of light", self.pieces.corners)
            self.depths = depths_between(self.pieces.corners.reshape(-1, 3), frame)
        texels = kept_texels(self.driver, max((end - begin for begin, end in self.ends), default=1))
        self.buffers, self.kept = light_buffers.light_buffers(device, self.driver.light_size, texels)
        self.values = uploaded(frame, self.program)
        self.values["planes"] = PlaneUniforms(tuple(turned.normal), turned.first, turned.spacing_world, turned.measured)
        size = frame.size_px
        self.part = FrameUniforms(size_px=size, tile_size_px=size, band_rows=size[1], step_world=frame.step_world)
        first = {"lamp": self._uniforms(0)} if self.ends else {"lamp": self._place()}
        self.groups = self._bound(first) if self.ends else []
        return first

    def _pieces(self) -> Pieces:
        """Proxies of the light's passes: each covers its group and the one before it, from where that is carried over."""
        low = [self.ends[max(turn - 1, 0)][0] for turn in range(len(self.ends))]
        high = [end for _, end in self.ends]
        numbers = (np.array(side, dtype=np.float64) - self.driver.bias for side in (low, high))
        edges = (self.planes.first + number * self.planes.spacing_world for number in numbers)
        return pieces_between(self._hull(), self.planes.normal, *edges)

    def _hull(self) -> Polyhedron:
        """What the volume may fill, and so much more that all texels round each of its points are drawn with it."""
        camera: Any = self.frame.scene_stages["camera"]
        reach = 1.0 if isinstance(camera, Orthographic) else float(np.linalg.norm(self._corners() - camera.eye, axis=1).max())
        texel = 2 * camera.half_height * reach / self.driver.light_size
        cosine = float(np.abs(ways_from(camera, self._corners()) @ self.planes.normal).min())
        return inflated(hull_of(self.frame), MARGIN_TEXELS * texel / cosine)

    def _corners(self) -> FloatArray:
        return corners_of(self.frame) - self.frame.anchor_world

    def _bound(self, told: dict[str, Any]) -> list[Any]:
        near, far = self.depths
        data = pack_uniforms(self.program, self.part, self.values | told | {"group": GroupUniforms(0.0, 1.0, near, far)})
        read = {"light_planes_out": self.kept} | written_clips(self.frame) | self._picture()
        return [bound_groups(self.frame, self.pipeline, {"light_before": one} | read, "light", data) for one in self.buffers]

    def _picture(self) -> dict[str, Any]:
        beam = self.lamp.light.beam
        return {} if beam is None else {"light_picture": light_buffers.picture_view(self.frame.device, beam.picture)}

    def looked_at(self) -> dict[str, Any]:
        """Return the light at the planes of a group."""
        return {"light_planes": self.kept} | self._picture()

    def start(self) -> None:
        """Begin with all of the light."""
        for target in self.buffers:
            raster.clear_target(self.frame.device, target, (0.0, 0.0, 0.0, UNTOUCHED))

    def carry(self, turn: int) -> dict[str, Any]:
        """Carry the light on through a group; return where the eye finds it."""
        device, (begin, end), (near, far) = self.frame.device, self.ends[turn], self.depths
        told = {"lamp": self._uniforms(turn)}
        group = {"group": GroupUniforms(begin - self.driver.bias, end - self.driver.bias, near, far)}
        target = device.kept.find(("buffer", "uniforms of light"))
        device.queue.write_buffer(target, 0, pack_uniforms(self.program, self.part, self.values | told | group))
        triangles = slice(int(self.pieces.first[turn]), int(self.pieces.first[turn + 1]))
        after = self.buffers[1 - turn % 2]
        raster.draw_into(device, self.pipeline, self.groups[turn % 2], after, self.corners, triangles)
        return told

    def _uniforms(self, turn: int) -> LampUniforms:
        begin, end = self.ends[turn]
        length = (end - begin) * self.planes.spacing_world
        first = self.planes.first + begin * self.planes.spacing_world
        voxel = min(min(layer.context.volume.spacing) for layer in self.frame.layers)
        spread = float(np.sqrt(length * voxel))
        return replace(self._place(), first=first, per_world=1 / self.planes.spacing_world, spread_world=spread)

    def _place(self) -> LampUniforms:
        camera: Any = self.frame.scene_stages["camera"]
        right, up, _ = camera.basis()
        beam = self.lamp.light.beam
        thrown = np.eye(4) if beam is None else picture_from_world(np.asarray(self.lamp.light.vector), beam)
        return LampUniforms(
            light_from_world=clip_from_world(camera),
            picture_from_world=thrown,
            normal=tuple(self.planes.normal),
            right=tuple(right),
            up=tuple(up),
            ambient=float(self.lamp.number == 0),
            begins=self.driver.transport.begins,
        )


def kept_texels(driver: HalfAngle, slices: int) -> int:
    """Texels of a ray for the light at all planes of so many slices: few numbers, so that turning lights keep a texture.

    One for each plane, or for three, which it holds with the one before them.
    """
    slices = min(driver.slices_at_once, -(-slices // KEPT_SLICES) * KEPT_SLICES)
    return -(-slices // 3) if driver.transport.is_grey else 1 + slices


def draw_lights(frame: MarchFrame, bands: list[Band]) -> None:
    """Draw bands of rows, light by light; what each makes is added up."""
    for number, (eye, light) in enumerate(frame.once(sweeps_of)):
        if number == 0:
            draw_groups(eye, bands, light)
            continue
        for band in bands:
            first, band.pictures = band.pictures, _others(frame, band)
            draw_groups(eye, [band], light)
            added, band.pictures = band.pictures, first
            _add(frame, band, {f"added_{name}": picture for name, picture in added.items()})


def _others(frame: MarchFrame, band: Band) -> dict[str, Any]:
    """Buffers like those of a band."""
    made = {"radiance": COLOUR, "depth": DEPTH}
    return {
        name: compute.storage_buffer(frame.device, ("another light", name, band.number), band.pixels * PIXEL_BYTES[kind.wgsl])
        for name, kind in made.items()
    }


def _add(frame: MarchFrame, band: Band, added: dict[str, Any]) -> None:
    device = frame.device
    names = ("radiance", "depth", "added_radiance", "added_depth")
    program = build_program(ProgramKey("passes/added.wgsl", (), (), names, (), Switches(), device.traits))
    pipeline = compute.pipeline_of(device, program)
    data = pack_uniforms(program, band.uniforms(), {})
    buffers = {"radiance": band.radiance, "depth": band.depth, **added}
    groups = bound_groups(frame, pipeline, buffers, "added", data)
    compute.dispatch_pixels(device, pipeline, groups, frame.size_px[0], band.rows)


def light_statistics(frame: MarchFrame) -> dict[str, Any]:
    """What ``image.stats`` says of lights: slices, groups and order of each one's sweep, and its buffers."""
    driver = frame.scene_stages["driver"]
    assert isinstance(driver, HalfAngle)
    eyes = [eye for eye, _ in frame.once(sweeps_of)]
    sweeps = [slice_statistics(eye)["slices"] for eye in eyes]
    longest = max((end - begin for eye in eyes for begin, end in eye.once(numbers_of).groups), default=1)
    texels = kept_texels(driver, longest)
    texel_bytes = 2 * light_buffers.TEXEL_BYTES + texels * light_buffers.PLANE_TEXEL_BYTES
    formats = [light_buffers.LIGHT_FORMAT, light_buffers.PLANES_FORMAT]
    kept = {"size": [driver.light_size] * 2, "formats": formats, "bytes": driver.light_size**2 * texel_bytes}
    return {"lights": {"sweeps": sweeps, "buffers": kept, "transport": driver.transport.name}}


def lights_program(frame: MarchFrame) -> Program:
    """Program by which the eye sees the first light."""
    eye, light = frame.once(sweeps_of)[0]
    return sweep_program(eye, light)


def first_planes(frame: MarchFrame) -> Planes | None:
    """Planes of the slices of the first light."""
    eye, _ = frame.once(sweeps_of)[0]
    return eye.once(planes_of)
