"""What lies under the pointer: values, place and label, of a pixel of the view or of a point of the world."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from ...annotations.scale_bar import length_text, unit_text
from ...errors import ValueRangeError
from ...inspecting import labels_at
from ...picking import Picked, pick
from ...profiles import RayProfile, ray_profile
from ...rendering.image import Image
from ...scene import Layer, Scene
from ...transfer.given import finite_numbers, listed, share, whole
from ...volume import FloatArray, Volume
from ..asking import answers

if TYPE_CHECKING:
    from ..session import Session

OWN_SCALE = 0.5
"""Of the view's size: the picture that is drawn where none is at hand."""
LEAST_OPACITY = 0.02
"""What is fainter is not found."""
MOST_MEASURES = 64
DIGITS = 4

_MEASURES: WeakKeyDictionary[Session, list[FloatArray]] = WeakKeyDictionary()


@answers("probe")
def probe(session: Session, x: float, y: float) -> dict[str, Any]:
    """What the picture shows at a place of the view.

    Parameters
    ----------
    session
        Whose picture.
    x, y
        The place, in parts of the view's width and height from its upper left corner.

    Returns
    -------
    dict
        ``hit``: whether anything is there; if so ``p_world``, ``t_world`` and what ``told`` adds; ``faint`` where what is seen
        is less than half opaque: the place is the mean of it then, weighted by opacity.

    Raises
    ------
    ValueRangeError
        For places beside the view.
    StageError
        When only the device knows the camera's rays.
    """
    image, scene = shown(session)
    pixel = pixel_at(image, x, y)
    if not scene.visible_layers:
        point = pick(image, scene, pixel)
        return {"hit": False} if point is None else {"hit": True, "p_world": list(point), "values": []}
    found = image.pick(*pixel)
    return faint(image, scene, x, y) if found is None else {"hit": True} | of_picked(scene, found)


@answers("probe.at")
def probe_at(session: Session, p_world: Any, layer: int = 0) -> dict[str, Any]:
    """What a layer holds at a point of the world, interpolated linearly, whether it is shown or not.

    Raises
    ------
    ValueRangeError
        For layers that are not there, and what is no point.
    """
    chosen = layer_numbered(session, layer)
    point = np.array(finite_numbers(p_world, "probe.p_world", 3))
    values = [float(chosen.volume.value_at(point, channel=c, time=chosen.time)) for c in chosen.channels]
    label = labels_at(chosen, point[None])
    return {"hit": not all(map(math.isnan, values)), "p_world": point.tolist(), "layer": int(layer)} | told(
        chosen, point, values, None if label is None else int(label[0])
    )


@answers("probe.measures")
def measures(session: Session, kept: Any = None) -> dict[str, Any]:
    """Distances and angles that were measured in a session; with ``kept`` these take their place.

    Parameters
    ----------
    session
        Which keeps them as long as it lives.
    kept
        Measures, each a list of two points of the world, a distance, or of three, the angle at the second.

    Returns
    -------
    dict
        ``measures``: of each its ``points``, ``value`` (world units, or degrees) and ``text``.

    Raises
    ------
    ValueRangeError
        For what are no points, and too many measures.
    """
    if kept is not None:
        given = listed(kept, "probe.measures", "give a list of lists of points")
        if len(given) > MOST_MEASURES:
            raise ValueRangeError("probe.measures", f"are {len(given)}, must be at most {MOST_MEASURES}", "remove some")
        _MEASURES[session] = [_points(points, f"probe.measures[{n}]") for n, points in enumerate(given)]
    layers = session.document.scene.layers
    units = layers[0].volume.units if layers else ""
    return {"measures": [measured(points, units) for points in _MEASURES.get(session, [])]}


def measured(points: FloatArray, units: str) -> dict[str, Any]:
    """The distance of two points (2, 3), or the angle of three (3, 3) at the second, as a number and as it is written."""
    first, second = points[0] - points[1], points[-1] - points[1]
    if len(points) == 2:
        value = float(np.linalg.norm(first))
        text = length_text(float(f"{value:.{DIGITS}g}"), units) if value > 0 else f"0 {unit_text(units)}".strip()
    else:
        across = float(np.linalg.norm(np.cross(first, second)))
        value = math.degrees(math.atan2(across, float(first @ second)))
        text = f"{value:.{DIGITS}g}°"
    return {"points": points.tolist(), "value": value, "text": text}


def _points(given: Any, where: str) -> FloatArray:
    points = listed(given, where, "give two or three points")
    if len(points) not in (2, 3):
        raise ValueRangeError(where, f"has {len(points)} points", "give two, or three for an angle")
    return np.array([finite_numbers(point, f"{where}[{n}]", 3) for n, point in enumerate(points)])


def of_picked(scene: Scene, found: Picked) -> dict[str, Any]:
    """What was picked, as plain data; ``layer`` is its number in the scene."""
    numbers = [number for number, layer in enumerate(scene.layers) if layer.visible]
    layer = scene.layers[numbers[found.layer]]
    more = told(layer, np.array(found.p_world), found.values, found.label)
    slope = {"gradient": math.hypot(*found.gradient), "gradient_unit": gradient_unit(layer.volume)}
    return {"p_world": list(found.p_world), "t_world": found.t_world, "layer": numbers[found.layer]} | slope | more


def faint(image: Image, scene: Scene, x: float, y: float) -> dict[str, Any]:
    """What is seen at a place where opacity does not reach one half, of the layer that has most of it."""
    width, height = image.size
    at = x * width, y * height
    best, least = None, LEAST_OPACITY
    for number, layer in enumerate(scene.visible_layers):
        if layer.look.integrate.name != "emission_absorption":
            continue
        ray = ray_profile(scene, image.size, at, layer=number, step=1.0)
        if ray.opacity.size and ray.opacity[-1] > least:
            best, least = (layer, ray), float(ray.opacity[-1])
    if best is None:
        return {"hit": False}
    layer, ray = best
    t_world = mean_distance(ray)
    p_world = np.array([np.interp(t_world, ray.t_world, ray.p_world[:, axis]) for axis in range(3)])
    number = next(n for n, other in enumerate(scene.layers) if other is layer)
    values = [float(layer.volume.value_at(p_world, channel=c, time=layer.time)) for c in layer.channels]
    label = labels_at(layer, p_world[None])
    place = {"hit": True, "faint": True, "p_world": p_world.tolist(), "t_world": t_world, "layer": number}
    return place | told(layer, p_world, values, None if label is None else int(label[0]))


def mean_distance(ray: RayProfile) -> float:
    """Mean distance of what is seen along a ray, weighted by the opacity that each slab adds; NaN where all is clear."""
    added = np.diff(ray.opacity)
    total = float(added.sum())
    return float((added * (ray.t_world[1:] + ray.t_world[:-1]) / 2).sum() / total) if total > 0 else math.nan


def told(layer: Layer, p_world: np.ndarray[Any, Any], values: Any, label: int | None) -> dict[str, Any]:
    """Values and label at a point, with names and units, and its voxel; values are None where there are none."""
    volume = layer.volume
    names = [volume.channel_names[c] if volume.channel_names else f"channel {c}" for c in layer.channels]
    p_index = volume.index_from_world[:3, :3] @ p_world + volume.index_from_world[:3, 3]
    found: dict[str, Any] = {
        "values": [None if math.isnan(value) else float(value) for value in values],
        "names": names if volume.channel_count > 1 else ["value"],
        "value_unit": volume.value_unit,
        "p_index": p_index.tolist(),
        "voxel": np.clip(np.rint(p_index), 0, np.array(volume.size) - 1).astype(int).tolist(),
        "units": unit_text(volume.units),
    }
    if label is not None and layer.labels is not None:
        found |= {"label": label, "label_name": layer.labels.name_of(label)}
    return found


def gradient_unit(volume: Volume) -> str:
    """Unit of gradients, where the volume tells those that it is made of."""
    return f"{volume.value_unit}/{unit_text(volume.units)}" if volume.value_unit and volume.units else ""


def layer_numbered(session: Session, layer: Any) -> Layer:
    """Layer of a session by its number in the scene.

    Raises
    ------
    ValueRangeError
        When there is none.
    """
    layers = session.document.scene.layers
    return layers[whole(layer, "layer", 0, len(layers) - 1)]


def shown(session: Session) -> tuple[Image, Scene]:
    """The picture that was sent last, with its depth, and what it shows; a coarse one is drawn where there is none."""
    image = session.stream.image
    if image is None or image.scene is None:
        document = session.document
        size = (max(1, round(session.size_px[0] * OWN_SCALE)), max(1, round(session.size_px[1] * OWN_SCALE)))
        key = (session.key, "probe")
        image = session.viewer.renderer.submit(document.scene, size, view=key, **document.drawing).result()
    assert image.scene is not None
    return image, image.scene


def pixel_at(image: Image, x: float, y: float) -> tuple[int, int]:
    """Column and row of an image at a place in parts of its width and height.

    Raises
    ------
    ValueRangeError
        For places beside it.
    """
    width, height = image.size
    column, row = share(x, "probe.x") * width, share(y, "probe.y") * height
    return min(int(column), width - 1), min(int(row), height - 1)
