"""A good first picture: transfer function, view and lights chosen from the data."""

from __future__ import annotations

import dataclasses

from .scene import Scene, fit_camera
from .transfer import TransferFunction
from .volume import Volume, statistics


def automatic_transfer(volume: Volume, channel: int | str = 0, time: int = 0) -> TransferFunction:
    """Return a ramp over the data's robust range."""
    known = statistics(volume, channel, time)
    low, high = known.percentile(60), known.percentile(99.8)
    size = max(s * n for s, n in zip(volume.spacing, volume.size, strict=True))
    if high <= low:
        high = low + 1
    return TransferFunction(
        [(low, (0.2, 0.1, 0.05), 0), ((low + high) / 2, (1, 0.6, 0.4), 10 / size), (high, (1, 1, 1), 100 / size)]
    )


def first_picture(volume: Volume, size_px: tuple[int, int] = (512, 512)) -> Scene:
    """Return the scene that shows a volume well without any choice of the user's."""
    return resolve(Scene(volume), size_px)


def resolve(scene: Scene, size_px: tuple[int, int]) -> Scene:
    """Fill in what a scene leaves open: transfer functions, and the camera of a named view."""
    layers = tuple(
        layer
        if layer.transfer is not None
        else dataclasses.replace(layer, transfer=automatic_transfer(layer.volume, layer.channel, layer.time))
        for layer in scene.layers
    )
    camera = scene.camera
    if isinstance(camera, str):
        corners = [c for layer in scene.visible_layers or scene.layers for c in layer.volume.corners_world()]
        camera = fit_camera(camera, corners, size_px[0] / size_px[1])
    return dataclasses.replace(scene, layers=layers, camera=camera)
