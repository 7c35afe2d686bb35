"""A good first picture: transfer function, view and lights chosen from the data."""

from __future__ import annotations

import dataclasses

from ..scene import Camera, Layer, Look, Scene, fit_camera
from ..stages.field_labels import are_alone
from ..stages.integrate import XRay
from ..stages.shade import BlinnPhong
from ..transfer import Channels, TransferFunction, presets
from ..transfer.attenuation import WATER_PER_MM
from ..volume import FloatArray, Volume, statistics
from .channels import automatic_channels, channels_picture
from .functions import SOLID_PER_VOXEL, chosen_function
from .survey import Survey, is_ct, survey
from .view import MARGIN, chosen_direction, chosen_lights, fitted_camera, visible_points

__all__ = [
    "automatic_channels",
    "automatic_transfer",
    "first_picture",
    "projection_transfer",
    "refitted_camera",
    "resolve",
    "resolved_camera",
]

BACKGROUND = (0.0, 0.0, 0.0)


def automatic_transfer(volume: Volume, channel: int | str = 0, time: int = 0) -> TransferFunction:
    """Return the transfer function that shows the object in a volume and not the noise round it.

    Chosen from the histogram, the faces of the grid, and what the file says of modality and units; kept with the volume.
    """
    cache: dict[tuple[int, int], TransferFunction] = volume.__dict__.setdefault("_automatic_transfers", {})
    slot = (volume.channel_index(channel), time)
    if slot not in cache:
        cache[slot] = chosen_function(volume, survey(volume, *slot))
    return cache[slot]


def projection_transfer(volume: Volume, channel: int | str = 0, time: int = 0) -> TransferFunction:
    """Black to white from the robust minimum to the maximum: what projections of values are shown with."""
    known = statistics(volume, channel, time)
    low = known.percentile(0.5)
    return TransferFunction([(low, "black", 0.0), (max(known.maximum, low), "white", 1.0)])


def attenuation_transfer(volume: Volume, channel: int | str = 0, time: int = 0) -> TransferFunction:
    """What attenuates X-rays: the coefficient that Hounsfield units stand for, or values from their robust minimum on."""
    known = statistics(volume, channel, time)
    if is_ct(volume, known):
        return TransferFunction.from_hounsfield(WATER_PER_MM * presets.MM_PER_UNIT.get(volume.units, 1.0))
    return projection_transfer(volume, channel, time)


def occupancy_transfer(volume: Volume) -> TransferFunction:
    """Solid where regions of labels take more than half of a place: what labels without an image are drawn with."""
    solid = SOLID_PER_VOXEL / min(volume.spacing)
    return TransferFunction([(0.25, "white", 0.0), (0.75, "white", solid)])


def first_picture(
    volume: Volume,
    size_px: tuple[int, int] = (512, 512),
    *,
    channel: int | str = 0,
    time: int = 0,
    channels: Channels | None = None,
) -> Scene:
    """Return the scene that shows one channel of a volume well without any choice of the user's.

    ``channels`` is a mixture to be shown instead, e.g. that of ``automatic_channels``.
    """
    if channels is not None:
        return channels_picture(volume, channels, size_px, time)
    found = survey(volume, volume.channel_index(channel), time)
    function = automatic_transfer(volume, channel, time)
    points = visible_points(volume, function, found)
    to_eye, up = chosen_direction(points, volume, found)
    camera = fitted_camera(points, to_eye, up, size_px[0] / size_px[1])
    return Scene(
        volume,
        transfer=function,
        look=_look(found),
        channel=channel,
        time=time,
        camera=camera,
        lights=chosen_lights(to_eye, up),
        background=BACKGROUND,
    )


def resolve(scene: Scene, size_px: tuple[int, int]) -> Scene:
    """Fill in what a scene leaves open: transfer functions, and the camera of a named view."""
    layers = tuple(
        layer if layer.transfer is not None else dataclasses.replace(layer, transfer=_function_for(layer))
        for layer in scene.layers
    )
    return dataclasses.replace(scene, layers=layers, camera=resolved_camera(scene, size_px))


def resolved_camera(scene: Scene, size_px: tuple[int, int]) -> Camera:
    """Camera of a scene; that of a named view shows all that is visible."""
    if not isinstance(scene.camera, str):
        return scene.camera
    corners = [
        c
        for layer in scene.visible_layers or scene.layers
        for c in layer.volume.corners_world(cells=getattr(layer.look.field, "cells", False))
    ]
    corners += [corner for shape in scene.meshes for corner in shape.corners_world]
    return fit_camera(scene.camera, corners, size_px[0] / size_px[1], margin=MARGIN * _room(scene))


def refitted_camera(scene: Scene, points_world: FloatArray, size_px: tuple[int, int]) -> Camera:
    """Camera that looks as the one of a first picture does, and shows all points (n, 3), with room for annotations."""
    camera = resolved_camera(scene, size_px)
    _, up, forward = camera.basis()
    return fitted_camera(points_world, -forward, up, size_px[0] / size_px[1], _room(scene))


def _room(scene: Scene) -> float:
    return max((annotation.margin for annotation in scene.annotations), default=1.0)


def _function_for(layer: Layer) -> TransferFunction:
    """Return a function for a layer without one; what projects values shows all of them."""
    if are_alone(layer.labels, layer.volume):
        return occupancy_transfer(layer.volume)
    projects = not getattr(layer.look.integrate, "uses_slabs", True)
    choose = projection_transfer if projects else automatic_transfer
    choose = attenuation_transfer if isinstance(layer.look.integrate, XRay) else choose
    return choose(layer.volume, layer.channel, layer.time)


def _look(found: Survey) -> Look:
    if found.kind == "labels":
        shade = BlinnPhong(ambient=0.25, diffuse=0.65, specular=0.06, shininess=15)
        return Look(field="nearest", gradient="sobel", transfer="postclassified", shade=shade)
    if found.kind in ("cloud", "filled", "signed", "constant"):
        return Look(shade=BlinnPhong(ambient=0.45, diffuse=0.5, specular=0.08, shininess=20))
    return Look(shade=BlinnPhong(ambient=0.14, diffuse=0.68, specular=0.16, shininess=25))
