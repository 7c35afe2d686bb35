"""What is drawn, as frozen values: layers with their looks, camera, lights and background."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from . import stages
from .annotations import Annotation, checked_annotations
from .clips import Clip, checked_clips
from .environment import Environment
from .errors import DataError, StageError, ValueRangeError
from .geometry import Lines, Mesh, Points
from .labels import Labels
from .light import Light, Vector
from .stage import Stage, make_stage
from .stages.camera import Camera
from .stages.field import Field
from .stages.field_labels import Occupancy, are_alone
from .stages.gradient import Gradient
from .stages.shade import Shade
from .stages.transfer import Transfer
from .transfer import TransferFunction, linear_rgb
from .transfer.channels import Channels
from .transfer.colour import MOST_COLOUR, Colour
from .transfer.given import listed, listed_values, not_negative, set_fields, whole
from .transfer.joint import JointFunction
from .transfer.kinds import AnyFunction, DrawnFunction, as_function, channels_of, drawn_function
from .volume import FloatArray, Volume, statistics

__all__ = ["VIEWS", "Camera", "Layer", "Light", "Look", "Scene", "fit_camera"]


@dataclass(frozen=True)
class Look:
    """The stages that fill the slots; each is given by name or as a stage with its parameters."""

    field: Stage
    gradient: Stage
    transfer: Stage
    modulation: Stage
    shade: Stage
    lighting: Stage
    visibility: Stage
    integrate: Stage
    tone: Stage

    def __init__(
        self,
        field: str | Stage = "linear",
        gradient: str | Stage = "central",
        transfer: str | Stage = "preintegrated",
        shade: str | Stage = "blinn_phong",
        lighting: str | Stage = "sampled",
        visibility: str | Stage = "none",
        integrate: str | Stage = "emission_absorption",
        tone: str | Stage = "linear",
        modulation: str | Stage = "none",
    ) -> None:
        choices = {
            "field": field,
            "gradient": gradient,
            "transfer": transfer,
            "modulation": modulation,
            "shade": shade,
            "lighting": lighting,
            "visibility": visibility,
            "integrate": integrate,
            "tone": tone,
        }
        for slot, choice in choices.items():
            object.__setattr__(self, slot, make_stage(slot, choice))

    def stages(self) -> dict[str, Stage]:
        """Return the stages by slot, those that this look never asks replaced by the ones that do nothing.

        Without light there is no gradient to compute, and without slabs there is nothing to light.
        """
        chosen = {name: getattr(self, name) for name in self.__dataclass_fields__}
        if not getattr(chosen["integrate"], "classifies", True):
            chosen["modulation"] = stages.modulation.NoModulation()
        shade = chosen["shade"]
        if not (isinstance(shade, Shade) and not shade.lit) and getattr(chosen["integrate"], "uses_slabs", True):
            return chosen
        asked = any(getattr(chosen[slot], "uses_gradient", slot == "modulation") for slot in ("modulation", "integrate"))
        return chosen | {
            "gradient": self.gradient if asked else stages.gradient.Zero(),
            "shade": stages.shade.NoShade(),
            "lighting": stages.lighting.Unlit(),
        }


@dataclass(frozen=True)
class Layer:
    """A volume with the look that it is drawn with.

    Parameters
    ----------
    volume
        A ``Volume``, or anything that makes one.
    transfer
        ``TransferFunction``, ``JointFunction``, or ``Channels`` (also given as a list of functions, one a channel); None
        chooses one from the data.
    look
        Stages and their parameters.
    labels
        ``Labels`` beside the image, or a volume of labels, on any grid, whose regions get colours of their own. Labels of the
        very volume are drawn without an image: the transfer function is one of the share, 0 to 1, of what regions take of a
        place, and the background is hidden unless it has a style.
    visible
        Whether the layer is drawn.
    density
        Factor of all extinctions, at least 0.
    channel, time
        Channel, by number or name, and time step.
    clips
        ``Clip``s of this layer alone, beside those of the scene.
    """

    volume: Volume
    transfer: AnyFunction | None = None
    look: Look = field(default_factory=Look)
    labels: Labels | None = None
    visible: bool = True
    density: float = 1.0
    channel: int | str = 0
    time: int = 0
    clips: tuple[Clip, ...] = ()

    def __post_init__(self) -> None:
        """Make a volume of what was given and check the numbers."""
        if isinstance(self.volume, (str, os.PathLike)):
            raise DataError("scene", f"got the path {str(self.volume)!r}", "pass airlight.open(path)")
        if not isinstance(self.volume, Volume):
            object.__setattr__(self, "volume", Volume(self.volume))
        density = not_negative(self.density, "layer.density")
        channel = self.channel if isinstance(self.channel, str) else whole(self.channel, "layer.channel", 0)
        set_fields(self, density=density, channel=channel, time=whole(self.time, "layer.time", 0))
        set_fields(self, clips=checked_clips(self.clips, "layer.clips"))
        object.__setattr__(self, "transfer", as_function(self.transfer))
        if self.transfer is not None and not isinstance(self.transfer, AnyFunction):
            found = f"is a {type(self.transfer).__name__}"
            remedy = "pass a TransferFunction, JointFunction or Channels"
            if isinstance(self.transfer, str):
                remedy += "; a preset is airlight.transfer.presets.get(name, volume)"
            raise DataError("layer.transfer", found, remedy)
        if not isinstance(self.look, Look):
            raise DataError("layer.look", f"is a {type(self.look).__name__}", "pass an airlight.Look")
        if self.labels is not None and not isinstance(self.labels, Labels):
            object.__setattr__(self, "labels", Labels(self.labels))
        if self.labels is not None:
            self.labels.volume.grid(0, self.labels.time_of(self.time))
            if are_alone(self.labels, self.volume) and self.labels.background not in self.labels.by_label:
                object.__setattr__(self, "labels", self.labels.hide(self.labels.background))
        self.volume.grid(self.channel, self.time)

    @cached_property
    def function(self) -> DrawnFunction:
        """The transfer function as it is drawn, with the layer's density and those of its labels; there must be one."""
        assert self.transfer is not None
        density = self.density * getattr(self.look.integrate, "thinned", 1.0)
        function = drawn_function(self.transfer, density)
        return function if self.labels is None else self.labels.beside(function, density)

    @property
    def channels(self) -> tuple[int, ...]:
        """Numbers of the channels that are kept for the transfer function."""
        channel = self.volume.channel_index(self.channel)
        return (channel,) if self.transfer is None else channels_of(self.transfer, self.volume, channel)

    def stages(self, keeps_gradient: bool = False) -> dict[str, Stage]:
        """Return the stages that draw the layer: its look's, or their stand-ins for the kind of function and data.

        Parameters
        ----------
        keeps_gradient
            Whether the look's gradient stage stays although nothing asks it while drawing.

        Raises
        ------
        StageError
            When a stage of the look has no way to draw them.
        """
        chosen = self.look.stages()
        field, transfer = chosen["field"], chosen["transfer"]
        self._check_integrate(chosen["integrate"])
        _check_visibility(chosen)
        if isinstance(transfer, Transfer):
            chosen["transfer"] = transfer = transfer.for_function(self.function)
            if getattr(chosen["lighting"], "splits_slabs", False):
                chosen["transfer"] = transfer.splitting()
            if keeps_gradient or transfer.uses_gradient(self.function):
                chosen["gradient"] = self.look.gradient
        if are_alone(self.labels, self.volume):
            chosen = Occupancy().arranged(chosen)
        elif isinstance(field, Field):
            field = field if len(self.channels) == 1 else field.for_channels()
            some_empty = any(statistics(self.volume, channel, self.time).empty for channel in self.channels)
            field = field.for_empty() if some_empty and not field.masked else field
            chosen = field.arranged(chosen)
        if isinstance(chosen["gradient"], Gradient):
            chosen = chosen["gradient"].arranged(chosen)
        return chosen | {"region": stages.region.for_labels(self.labels, self.function, chosen)}

    def _check_integrate(self, integrate: Stage) -> None:
        """Refuse stages that show one value where the function looks at several, or at what a mean value does not have."""
        function, where = self.function, f"look.integrate {integrate.name!r}"
        if getattr(integrate, "classifies", True):
            return
        count = len(function.visible) if isinstance(function, Channels) else len(self.channels)
        if count > 1:
            remedy = "show one: transfer=function, channel=number (--channel N)"
            raise StageError(where, f"shows values, and there are {count} channels of them", remedy)
        if isinstance(function, JointFunction) and not getattr(integrate, "colours_samples", True):
            raise StageError(where, "makes a value that has no gradient", "use a TransferFunction, or mip or minip")


def _check_visibility(chosen: Mapping[str, Stage]) -> None:
    """Refuse a stage that dims light where there is none."""
    shade, visibility = chosen["shade"], chosen["visibility"]
    if visibility.name != "none" and isinstance(shade, Shade) and not shade.lit:
        where = f"look.visibility {visibility.name!r}"
        raise StageError(where, "dims light, and nothing is lit", 'use shade="blinn_phong", or visibility="none"')
    if getattr(visibility, "of_lights", False) and isinstance(shade, Shade) and not shade.asks_lights:
        what = f"dims lights, and shade {shade.name!r} asks none"
        raise StageError(f"look.visibility {visibility.name!r}", what, 'use shade="blinn_phong", or another visibility')


@dataclass(frozen=True, init=False)
class Scene:
    """Layers, camera, lights and background: all that an image depends on but its size and the driver.

    Parameters
    ----------
    volume
        Short for ``layers=[Layer(volume, transfer=..., ...)]``, with all that a ``Layer`` takes.
    layers
        What is drawn.
    camera
        A ``Camera``, or the name of a view (``"front"``, ``"iso"`` ...) that shows all layers.
    lights
        Lights; None is one head light.
    meshes
        What shares its depth with the layers: ``Mesh``, ``Lines`` and ``Points``. A scene of meshes needs no layer.
    background
        Colour that lies behind the finished image; None is transparent. An ``Environment`` is seen behind the layers as part of
        the scene: the tone stage maps it, too, and the image is opaque.
    clips
        ``Clip``s of all layers: what every one of them keeps is drawn.
    annotations
        What is drawn beside the data: ``ScaleBar``, ``ColorBar``, ``Grid``, ``Axes``, ``Orientation``, ``Pointer``. Lines and
        arrows share their depth with all else; what is written lies over the finished picture and is not in ``image.rgba``.
    """

    layers: tuple[Layer, ...]
    camera: Camera | str
    lights: tuple[Light, ...]
    background: Vector | Environment | None
    meshes: tuple[Mesh | Lines | Points, ...]
    clips: tuple[Clip, ...]
    annotations: tuple[Annotation, ...]

    def __init__(
        self,
        volume: Any = None,
        *,
        layers: Iterable[Layer] | None = None,
        transfer: AnyFunction | Sequence[TransferFunction] | None = None,
        look: Look | None = None,
        labels: Any = None,
        visible: bool | None = None,
        density: float | None = None,
        channel: int | str | None = None,
        time: int | None = None,
        camera: Camera | str = "front",
        lights: Iterable[Light] | None = None,
        background: Colour | Environment | None = (0.0, 0.0, 0.0),
        clips: Iterable[Clip] = (),
        meshes: Iterable[Mesh | Lines | Points] = (),
        annotations: Iterable[Annotation] = (),
    ) -> None:
        meshes = listed(meshes, "scene.meshes", "pass meshes=[airlight.Mesh(vertices, faces)]")
        layers = () if meshes and volume is None and layers is None else layers
        if (volume is None) == (layers is None):
            raise DataError("scene", "needs either a volume or layers", "pass one of them")
        optional: dict[str, Any] = {"transfer": transfer, "look": look, "labels": labels, "visible": visible}
        optional |= {"density": density, "channel": channel, "time": time}
        given = {name: value for name, value in optional.items() if value is not None}
        if layers is None:
            layers = [Layer(volume, **given)]
        elif given:
            raise DataError("scene", f"got layers beside {' and '.join(given)}", "give it to the layers")
        layers = listed(layers, "scene.layers", "pass layers=[airlight.Layer(volume)]")
        for layer in layers:
            if not isinstance(layer, Layer):
                raise DataError("scene.layers", f"holds a {type(layer).__name__}", "make a Layer of it: airlight.Layer(volume)")
        if not (isinstance(camera, Camera) or (isinstance(camera, str) and camera in VIEWS)):
            raise ValueRangeError("scene.camera", f"is {camera!r}, must be a Camera or one of {', '.join(VIEWS)}")
        object.__setattr__(self, "layers", layers)
        object.__setattr__(self, "camera", camera)
        making = "make lights with Light.head(), .directional() or .point()"
        given_lights = [Light.head()] if lights is None else lights
        object.__setattr__(self, "lights", listed_values(given_lights, Light, "scene.lights", "pass lights=[light]", making))
        if background is not None and not isinstance(background, Environment):
            background = linear_rgb(background, "scene.background", MOST_COLOUR)
        object.__setattr__(self, "background", background)
        object.__setattr__(self, "clips", checked_clips(clips, "scene.clips"))
        object.__setattr__(self, "meshes", meshes)
        object.__setattr__(self, "annotations", checked_annotations(annotations, "scene.annotations"))
        for mesh in meshes:
            if not isinstance(mesh, Mesh | Lines | Points):
                raise DataError("scene.meshes", f"holds a {type(mesh).__name__}", "make it an airlight.Mesh, Lines or Points")
        if not self.layers and not meshes:
            raise DataError("scene.layers", "is empty", "pass at least one Layer")

    @property
    def visible_layers(self) -> tuple[Layer, ...]:
        """Layers that are not hidden."""
        return tuple(layer for layer in self.layers if layer.visible)

    @property
    def drawn_layers(self) -> tuple[Layer, ...]:
        """Visible layers that may be seen: of several, those without density are left out."""
        visible = self.visible_layers
        return tuple(layer for layer in visible if layer.density > 0) or visible[:1]

    def clips_of(self, layer: Layer) -> tuple[Clip, ...]:
        """Clips that cut a layer: the scene's, then its own."""
        return self.clips + layer.clips


def check_scene(given: Any, remedy: str = "pass an airlight.Scene") -> None:
    """Refuse what is no scene.

    Raises
    ------
    DataError
        Tells what it is.
    """
    if not isinstance(given, Scene):
        raise DataError("scene", f"is a {type(given).__name__}", remedy)


# -- views

# Name of a view: direction from the middle of the object towards the eye, and up. LPS: x left, y posterior, z superior.
VIEWS: dict[str, tuple[Vector, Vector]] = {
    "front": ((0, -1, 0), (0, 0, 1)),
    "back": ((0, 1, 0), (0, 0, 1)),
    "left": ((1, 0, 0), (0, 0, 1)),
    "right": ((-1, 0, 0), (0, 0, 1)),
    "top": ((0, 0, 1), (0, -1, 0)),
    "bottom": ((0, 0, -1), (0, -1, 0)),
    "iso": ((0.55, -0.75, 0.35), (0, 0, 1)),
}


def fit_camera(
    view: str,
    points_world: FloatArray | Sequence[Vector],
    aspect: float = 1.0,
    fov_deg: float = 30.0,
    margin: float = 1.05,
) -> Camera:
    """Perspective camera of a named view that shows all the points.

    Parameters
    ----------
    view
        One of ``VIEWS``.
    points_world
        Points (n, 3), e.g. the corners of a box.
    aspect
        Width of the image over its height.
    fov_deg
        Vertical angle of view in degrees.
    margin
        Factor by which the image is larger than what it must show.
    """
    if view not in VIEWS:
        raise ValueRangeError("camera", f"is {view!r}, must be one of {', '.join(VIEWS)}")
    points = np.asarray(points_world, dtype=np.float64)
    target = (points.min(axis=0) + points.max(axis=0)) / 2
    to_eye = np.asarray(VIEWS[view][0], dtype=np.float64)
    to_eye /= np.linalg.norm(to_eye)
    right = np.cross(-to_eye, VIEWS[view][1])
    right /= np.linalg.norm(right)
    up = np.cross(right, -to_eye)
    tangent = math.tan(math.radians(fov_deg) / 2) / margin
    from_target = points - target
    # A point at depth z towards the eye, x to the side, is inside where |x| <= (distance - z) * tangent.
    aside = np.maximum(np.abs(from_target @ right) / (tangent * aspect), np.abs(from_target @ up) / tangent)
    distance = float((from_target @ to_eye + aside).max())
    distance = max(distance, 1e-6 * float(np.abs(points).max()), 1e-12)
    x, y, z = target + distance * to_eye
    return Camera.perspective(eye=(x, y, z), target=tuple(target), up=VIEWS[view][1], fov_deg=fov_deg)
