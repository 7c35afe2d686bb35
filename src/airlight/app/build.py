"""From what was typed to what is drawn: the scene, the size, and the arguments of ``airlight.render``."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import DataError, ValueRangeError
from ..first_picture import automatic_channels, first_picture, projection_transfer, resolved_camera
from ..scene import Camera, Layer, Look, Scene
from ..stage import Stage
from ..stages.camera import Orthographic, Perspective, Stereo
from ..transfer import Surface, TransferFunction, presets
from ..transfer.colormaps import colours_of
from ..volume import Volume
from .annotations import asked_annotations, with_annotations, with_room
from .clips import check_cut, cropped, parse_clips, parse_crop, with_clips
from .inputs import open_named
from .labels import LabelOptions, with_labels
from .layers import open_layers, parse_layer
from .lights import check_lit, parse_lights
from .meshes import boxes, open_meshes, parse_mesh
from .options import SLOTS, DrawOptions, LookOptions, ReadOptions, ViewOptions
from .parse import (
    parse_background,
    parse_bytes,
    parse_camera,
    parse_channels,
    parse_iso,
    parse_shape,
    parse_size,
    parse_spacing,
    parse_stage,
    parse_transfer,
)
from .progress import ProgressBar
from .surroundings import BACKGROUND, check_lights, environment_of, lit_by, seen_behind

SIZE = (512, 512)
STEPPING = ("step", "tolerance", "budget_ms")  # each chooses the step
PROJECTIONS = ("mip", "minip", "mean", "attenuated_mip", "depth_shaded_mip", "local_mip")
SUMS = ("weighted_sum", "xray")
BOUNDARY_DEPTHS = (0.12, 0.4, 1.2)
"""Optical depths of boundaries by rising value: outer ones, of lower values, are faint, so that inner ones show."""


@dataclass(frozen=True)
class Job:
    """A scene with the size of its image and further arguments of ``airlight.render``: driver, step, tolerance, skip ..."""

    scene: Scene
    size: tuple[int, int]
    arguments: dict[str, Any]


def is_scene(path: str) -> bool:
    """Whether a path names a scene file."""
    return path.lower().endswith(".toml")


def open_input(path: str, read: ReadOptions, progress: ProgressBar | None = None) -> Volume:
    """Open a volume as the options tell, or a sample by its name."""
    return open_named(
        path,
        progress,
        dataset=read.dataset,
        level=read.level,
        shape=None if read.shape is None else parse_shape(read.shape),
        dtype=read.dtype,
        spacing=None if read.spacing is None else parse_spacing(read.spacing),
        offset=read.offset,
        big_endian=read.big_endian,
        max_memory=parse_bytes(read.max_memory),
    )


def make_job(
    path: str,
    look: LookOptions,
    view: ViewOptions,
    draw: DrawOptions,
    read: ReadOptions,
    progress: ProgressBar | None = None,
    labels: LabelOptions | None = None,
) -> Job:
    """Make what is drawn of a volume or a scene file; options take the place of what the file says.

    Everything typed is parsed before a file is opened, so that slips show at once.
    """
    size = None if view.size is None else parse_size(view.size)
    stages = {slot: parse_stage(slot, text) for slot in SLOTS if (text := getattr(look, slot)) is not None}
    function = None if look.tf is None else parse_transfer(look.tf)
    given = [option for option in ("tf", "preset", "colormap", "auto", "channels") if getattr(look, option) is not None]
    if len(given) > 1:
        raise ValueRangeError(f"--{given[0]}", f"and --{given[1]} exclude each other", "leave one of them out")
    if look.colormap is not None:
        colours_of(look.colormap)
    colours = None if look.channels is None else parse_channels(look.channels)
    if look.channels is not None and look.channel is not None:
        raise ValueRangeError("--channels", "and --channel exclude each other", "leave one of them out")
    surfaces = parse_iso(look.iso)
    camera = None if view.camera is None else parse_camera(view.camera)
    clips, crop = parse_clips(view.clip), None if view.crop is None else parse_crop(view.crop)
    arguments = _draw_arguments(draw)
    changes: dict[str, Any] = {} if camera is None else {"camera": camera}
    environment = environment_of(look.environment, look.environment_turn)
    if look.light:
        changes["lights"] = parse_lights(look.light)
    annotations = asked_annotations(look)
    meshes = tuple(parse_mesh(text) for text in look.mesh)
    others = tuple(parse_layer(text) for text in look.layer)
    if view.background is not None and view.background != BACKGROUND:
        changes["background"] = parse_background(view.background)
    if is_scene(path):
        scene, options = _load(path, read, progress)
        # Whoever types how well it is to be drawn does not mean what the file says of it.
        left = ("size", *(STEPPING if any(key in arguments for key in STEPPING) else ()))
        arguments = {key: value for key, value in options.items() if key not in left} | arguments
        size = size or options.get("size") or SIZE
    else:
        size = size or SIZE
        scene = _picture_of(open_input(path, read, progress), _of_one_eye(size) if view.stereo else size, look, colours)
    check_cut(scene, clips, crop)
    layers = tuple(_with_look(layer, look, stages) for layer in scene.layers)
    if look.channels is not None:
        layers = tuple(
            dataclasses.replace(layer, transfer=automatic_channels(layer.volume, colours, layer.time)) for layer in layers
        )
    if look.auto is not None:
        layers = tuple(_with_boundaries(layer, look.auto, progress) for layer in layers)
    if function is not None:
        layers = tuple(dataclasses.replace(layer, transfer=function) for layer in layers)
    if surfaces:
        layers = tuple(_with_surfaces(layer, surfaces, alone=not given and not is_scene(path)) for layer in layers)
    if labels is not None:
        layers = tuple(with_labels(layer, labels, progress, parse_bytes(read.max_memory)) for layer in layers)
    layers = (*layers, *open_layers(others, layers, parse_bytes(read.max_memory), progress))
    layers = tuple(cropped(lit_by(layer, environment, look.shade is not None), crop) for layer in layers)
    if look.mesh or look.box is not None:
        drawn = () if look.box is None else boxes(layers, look.box)
        changes["meshes"] = (*scene.meshes, *open_meshes(meshes), *drawn)
    scene = with_annotations(with_clips(dataclasses.replace(scene, layers=layers, **changes), clips), annotations)
    if camera is None and not is_scene(path):
        scene = with_room(scene, _of_one_eye(size) if view.stereo else size)
    if look.light:
        check_lit(scene)
    if view.background == BACKGROUND:
        scene = dataclasses.replace(scene, background=seen_behind(scene, environment))
    elif environment is not None:
        check_lights(layers, look.shade)
    if view.stereo:
        scene = stereo(scene, size)
    return Job(orthographic(scene, size) if view.orthographic else scene, size, arguments)


def _draw_arguments(draw: DrawOptions) -> dict[str, Any]:
    asked = {"step": draw.step, "tolerance": draw.tolerance, "budget_ms": draw.budget, "skip": draw.skip}
    arguments: dict[str, Any] = {key: value for key, value in asked.items() if value is not None}
    if draw.step is not None and not (math.isfinite(draw.step) and draw.step > 0):
        raise ValueRangeError("--step", f"is {draw.step}, must be above 0")
    if draw.driver is not None or draw.offsets is not None:
        driver = parse_stage("driver", draw.driver or "march")
        if draw.offsets is not None:
            driver = _changed(driver, "offsets", draw.offsets, "march")
        arguments["driver"] = driver
    if draw.transport is not None:
        driver = arguments.get("driver") or parse_stage("driver", "half_angle")
        arguments["driver"] = _changed(driver, "transport", parse_stage("transport", draw.transport), "half_angle")
    if draw.passes:
        arguments["passes"] = tuple(parse_stage("passes", text, "pass") for text in draw.passes)
    return arguments


def _changed(driver: Stage, name: str, choice: Any, known: str) -> Stage:
    """Return the driver with an option of its own; ``known`` is one that has it."""
    if not any(f.name == name for f in dataclasses.fields(driver)):  # type: ignore[arg-type]
        raise ValueRangeError(f"--{name}", f"is given, but the driver {driver.name} has none", f"use --driver {known}")
    changed: Stage = dataclasses.replace(driver, **{name: choice})  # type: ignore[type-var]
    return changed


def _load(path: str, read: ReadOptions, progress: ProgressBar | None) -> tuple[Scene, Any]:
    from ..scene_file import load_scene

    limits = {"max_memory": "8G"}
    for field in dataclasses.fields(read):
        if field.name not in limits and getattr(read, field.name) != field.default:
            name = field.name.replace("_", "-")
            raise ValueRangeError(f"--{name}", "tells how to read a volume", "a scene file tells it itself, layer by layer")
    return load_scene(path, max_memory=parse_bytes(read.max_memory), progress=progress)


def _picture_of(volume: Volume, size: tuple[int, int], look: LookOptions, colours: Mapping[int | str, Any] | None) -> Scene:
    """Return the scene of a good first picture, of the channels and time step that are asked for."""
    if look.channels is not None:
        time = look.time or 0
        return first_picture(volume, size, time=time, channels=automatic_channels(volume, colours, time))
    return first_picture(volume, size, channel=_channel(look), time=look.time or 0)


def _channel(look: LookOptions) -> int | str:
    text = look.channel or "0"
    return int(text) if text.isdecimal() else text


def _with_look(layer: Layer, look: LookOptions, stages: dict[str, Stage]) -> Layer:
    changes: dict[str, Any] = {}
    if stages:
        changes["look"] = Look(**{slot: stages.get(slot, getattr(layer.look, slot)) for slot in SLOTS})
    if look.channel is not None:
        changes["channel"] = _channel(look)
    if look.time is not None:
        changes["time"] = look.time
    channel, time = changes.get("channel", layer.channel), changes.get("time", layer.time)
    projects = "integrate" in stages and stages["integrate"].name in PROJECTIONS
    if look.preset is not None and projects:
        raise ValueRangeError(
            "--preset",
            "is for opacity, and projections show values",
            "leave it out: they run from black to white, or give --tf or --colormap",
        )
    if look.preset is not None:
        changes["transfer"] = presets.get(look.preset, layer.volume, channel, time)
    elif look.colormap is not None:
        changes["transfer"] = presets.glowing(look.colormap, layer.volume, channel, time)
    elif projects:
        changes["transfer"] = projection_transfer(layer.volume, channel, time)
    elif "integrate" in stages and stages["integrate"].name in SUMS:
        changes["transfer"] = None  # chosen for the stage when it is drawn
    return dataclasses.replace(layer, **changes) if changes else layer


def _with_boundaries(layer: Layer, kind: str, progress: ProgressBar | None) -> Layer:
    """Return the layer with a function that shows the boundaries between materials."""
    if layer.look.integrate.name in PROJECTIONS:
        raise ValueRangeError("--auto", "is for opacity, and projections show values", "leave it out")
    # Only here: what it needs is a good part of what loading takes.
    from ..transfer.automatic import boundary_function, boundary_joint_function

    make: Any = {"boundaries": boundary_function, "boundaries2d": boundary_joint_function}[kind]
    try:
        function = make(layer.volume, layer.channel, layer.time, depth=BOUNDARY_DEPTHS, progress=progress)
    except DataError as error:
        remedy = "labels have no materials: leave it out" if layer.volume.modality == "labels" else "give --preset or --tf"
        raise DataError(f"--auto {kind}", f"finds nothing: {error.where} {error.what}", remedy) from None
    return dataclasses.replace(layer, transfer=function)


def _with_surfaces(layer: Layer, surfaces: tuple[Surface, ...], alone: bool) -> Layer:
    """Return the layer with surfaces beside its function, or in the place of a function that was chosen from the data."""
    way = layer.look.integrate
    if not getattr(way, "classifies", True) and getattr(way, "iso", None) is None:
        value = f"{surfaces[0].value:g}"
        remedy = f"name its value: --integrate first_hit:iso={value}" if way.name == "first_hit" else "leave one out"
        raise ValueRangeError("--iso", f"is given, and --integrate {way.name} draws no surfaces", remedy)
    if alone or layer.transfer is None:
        return dataclasses.replace(layer, transfer=TransferFunction.from_surfaces(surfaces))
    if not isinstance(layer.transfer, TransferFunction):
        what = f"goes with functions of one value, and here is a {type(layer.transfer).__name__}"
        raise ValueRangeError("--iso", what, "leave it out, or give --tf")
    return dataclasses.replace(layer, transfer=layer.transfer.with_surfaces(surfaces))


def orthographic(scene: Scene, size: tuple[int, int]) -> Scene:
    """Return the scene with parallel rays; the image shows what the perspective one shows at its target."""
    camera = resolved_camera(scene, size)
    if isinstance(camera, Orthographic):
        return scene
    if not isinstance(camera, Perspective):
        raise ValueRangeError("--orthographic", f"does not go with the camera {camera.name}", "leave it out")
    height = 2 * math.dist(camera.eye, camera.target) * math.tan(math.radians(camera.fov_deg) / 2)
    parallel = Camera.orthographic(eye=camera.eye, target=camera.target, up=camera.up, height=height)
    return dataclasses.replace(scene, camera=parallel)


def stereo(scene: Scene, size: tuple[int, int]) -> Scene:
    """Return the scene with the views of both eyes side by side; each shows what the perspective camera shows at its target."""
    camera = resolved_camera(scene, _of_one_eye(size))
    if isinstance(camera, Stereo):
        return scene
    if not isinstance(camera, Perspective):
        raise ValueRangeError("--stereo", f"does not go with the camera {camera.name}", "leave it out")
    eyes = Camera.stereo(eye=camera.eye, target=camera.target, up=camera.up, fov_deg=camera.fov_deg)
    return dataclasses.replace(scene, camera=eyes)


def _of_one_eye(size: tuple[int, int]) -> tuple[int, int]:
    return max(size[0] // 2, 1), size[1]
