"""Light: how a point answers to it, how much of it arrives, and where within a slab it is evaluated.

- shade: ``light(setup, sample, gradient (n, 3), to_eye (n, 3)) -> Lit``
- visibility: ``visibility(setup, light_index, p_world (n, 3)) -> (n, 3)``; light_index None asks for ambient light
- lighting: ``light_slab(setup, slab, to_eye) -> rgb (n, 3)``, associated
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..scene import Light
from ..transfer.channels import Channels, Slope
from ..volume import FloatArray, statistics
from .field import field_value
from .gradient import field_gradient
from .setup import IntArray, Lit, Sample, Setup, Slab


def none(setup: Setup, sample: Sample, gradient: FloatArray, to_eye: FloatArray) -> Lit:
    """Leave the colour as it is."""
    return Lit(np.ones_like(to_eye), np.zeros_like(to_eye))


@np.errstate(under="ignore")
def blinn_phong(setup: Setup, sample: Sample, gradient: FloatArray, to_eye: FloatArray) -> Lit:
    """Ambient, diffuse and specular light at the normal ``-gradient / |gradient|``."""
    stage = setup.stages["shade"]
    threshold = automatic_threshold(setup) if stage.gradient_threshold is None else stage.gradient_threshold
    steepness = np.linalg.norm(gradient, axis=1)
    surface = surfaceness(steepness, threshold)
    normal = np.where((surface > 0)[:, None], -gradient / np.where(surface > 0, steepness, 1.0)[:, None], 0.0)
    diffuse = stage.ambient * visibility(setup, None, sample.p_world)
    specular = np.zeros_like(diffuse)
    for index, lamp in enumerate(setup.lights):
        to_light, factor = incidence(lamp, sample.p_world, to_eye)
        arriving = np.outer(surface * factor, lamp.intensity * np.array(lamp.colour))
        strength = arriving * visibility(setup, index, sample.p_world)
        facing = np.abs if stage.two_sided else _positive
        n_dot_l = facing(_dot(normal, to_light))
        n_dot_h = facing(_dot(normal, _unit(to_light + to_eye)))
        highlight = np.where(n_dot_l > 0, n_dot_h**stage.shininess, 0.0)
        diffuse = diffuse + strength * (stage.diffuse * n_dot_l)[:, None]
        specular = specular + strength * (stage.specular * highlight)[:, None]
    return Lit(diffuse, specular)


@np.errstate(under="ignore")
def phase(setup: Setup, sample: Sample, gradient: FloatArray, to_eye: FloatArray) -> Lit:
    """Ambient light, and what Henyey and Greenstein's phase function sends to the eye of each light."""
    stage = setup.stages["shade"]
    g, diffuse = stage.forward, stage.ambient * visibility(setup, None, sample.p_world)
    for index, lamp in enumerate(setup.lights):
        to_light, factor = incidence(lamp, sample.p_world, to_eye)
        share = (1 - g * g) / (1 + g * g + 2 * g * _dot(to_light, to_eye)) ** 1.5
        arriving = np.outer(factor * share, lamp.intensity * np.array(lamp.colour))
        diffuse = diffuse + stage.strength * arriving * visibility(setup, index, sample.p_world)
    return Lit(diffuse, np.zeros_like(diffuse))


def surfaceness(steepness: FloatArray, threshold: float) -> FloatArray:
    """How far gradients (n,) mean a surface: from 0 at a threshold to 1 at twice of it."""
    if threshold == 0:
        return (steepness > 0).astype(np.float64)
    return np.clip(steepness / threshold - 1, 0.0, 1.0)


def automatic_threshold(setup: Setup) -> float:
    """1/2000 of the range between the percentiles 0.5 and 99.5 per smallest spacing."""
    if setup.stages["field"].name == "occupancy":
        return 1 / 2000 / setup.spacing_world
    volume, ranges = setup.layer.volume, []
    mixture = isinstance(setup.function, Channels)
    # A mixture has the range of the channel that weighs most, of what is seen of it.
    named = [part.channel for part in setup.function.visible] if mixture else [setup.channels[0]]
    for channel, line in zip(named, setup.function.slopes if mixture else [Slope(1.0)], strict=True):
        known = statistics(volume, channel, setup.layer.time)
        low, high = np.clip([known.percentile(0.5), known.percentile(99.5)], line.low, line.high)
        ranges.append(abs(line.weight) * (high - low))
    return float(max(ranges)) / 2000 / setup.spacing_world


def incidence(lamp: Light, p_world: FloatArray, to_eye: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Direction towards a light (n, 3), and its fall-off (n,)."""
    if lamp.kind == "head":
        return to_eye, np.ones(len(p_world))
    if lamp.kind == "directional":
        return np.broadcast_to(np.array(lamp.vector), p_world.shape), np.ones(len(p_world))
    way = np.array(lamp.vector) - p_world
    distance = np.maximum(np.linalg.norm(way, axis=1), 1e-30)
    return _unit(way), np.ones(len(p_world)) if lamp.radius is None else (lamp.radius / distance) ** 2


def visibility(setup: Setup, light_index: int | None, p_world: FloatArray) -> FloatArray:
    """Share (n, 3) of a light, or of ambient light, that reaches points."""
    return VISIBILITIES[setup.stages["visibility"].name](setup, light_index, p_world)


def no_occlusion(setup: Setup, light_index: int | None, p_world: FloatArray) -> FloatArray:
    """All of it."""
    return np.ones_like(p_world)


def unlit(setup: Setup, slab: Slab, to_eye: FloatArray) -> FloatArray:
    """Keep the slab's colour."""
    return slab.rgb


def sampled(setup: Setup, slab: Slab, to_eye: FloatArray) -> FloatArray:
    """Light slabs that are not empty at one place: where their light comes from on the mean, their middle, or their front."""
    whole, back = slab.rgb.sum(axis=1) + slab.alpha, slab.back_rgb.sum(axis=1) + slab.back_alpha
    middle = np.full(len(whole), 0.5)
    share = {
        "light": lit_place(setup, slab, np.where(whole > 0, back / np.where(whole > 0, whole, 1.0), 0.5)),
        "middle": middle,
        "front": np.zeros(len(whole)),
    }
    return _lit_at(setup, slab, to_eye, share[setup.stages["lighting"].at])


def lit_place(setup: Setup, slab: Slab, share: FloatArray) -> FloatArray:
    """Shares (n,) of slabs at which the field has the value that the straight line has at given shares, by one line more.

    Less is made of it where the ends differ by less than an eighth of what the field is off by, nothing of several channels.
    """
    if slab.front.value.ndim > 1 or not share.size:
        return share
    point = slab.front.towards(slab.back, share)
    found, empty = field_value(setup, point.p_index)
    off, rise = np.where(empty, 0.0, found - point.value), slab.back.value - slab.front.value
    passed = (off > 0) == (rise > 0)
    rest = np.abs(np.where(passed, point.value - slab.front.value, slab.back.value - point.value))
    some = off != 0
    part = np.where(some, np.abs(off) / np.where(some, rest + np.abs(off), 1.0), 0.0)
    told = np.maximum(np.abs(off), 1e-4 * np.maximum(np.abs(slab.front.value), np.abs(slab.back.value)))
    trust = np.where(some, np.minimum(8 * np.abs(rise) / np.where(some, told, 1.0), 1.0), 0.0)
    return np.asarray(share + trust * part * np.where(passed, -share, 1 - share))


def supersampled(setup: Setup, slab: Slab, to_eye: FloatArray) -> FloatArray:
    """Light slabs that are not empty at the two nodes of Gauss' rule."""
    nodes = 0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12)
    return np.asarray(sum(_lit_at(setup, slab, to_eye, np.full(len(slab.length), share)) for share in nodes) / 2)


def averaged(setup: Setup, slab: Slab, to_eye: FloatArray) -> FloatArray:
    """Light slabs that are not empty once, by the mean of the gradients at their two ends."""
    rows = _shining(slab)
    front, back = slab.front[rows], slab.back[rows]
    gradient = (field_gradient(setup, front.p_index) + field_gradient(setup, back.p_index)) / 2
    lit = SHADES[setup.stages["shade"].name](setup, front.towards(back, np.full(len(rows), 0.5)), gradient, to_eye[rows])
    rgb = slab.rgb.copy()
    rgb[rows] = rgb[rows] * lit.diffuse + slab.alpha[rows, None] * lit.specular
    return rgb


def interpolated(setup: Setup, slab: Slab, to_eye: FloatArray) -> FloatArray:
    """Light slabs that are not empty at both ends, each with its part of their colour."""
    rows = _shining(slab)
    rgb, total = slab.rgb.copy(), np.zeros((len(rows), 3))
    parts = (slab.front, slab.rgb - slab.back_rgb, slab.alpha - slab.back_alpha), (slab.back, slab.back_rgb, slab.back_alpha)
    for end, part_rgb, part_alpha in parts:
        here = end[rows]
        lit = SHADES[setup.stages["shade"].name](setup, here, field_gradient(setup, here.p_index), to_eye[rows])
        total += part_rgb[rows] * lit.diffuse + part_alpha[rows, None] * lit.specular
    rgb[rows] = total
    return rgb


def _shining(slab: Slab) -> IntArray:
    """Numbers of the slabs that send anything."""
    return np.nonzero((slab.alpha > 0) | (slab.rgb > 0).any(axis=1))[0]


def _lit_at(setup: Setup, slab: Slab, to_eye: FloatArray, share: FloatArray) -> FloatArray:
    """Light slabs as they are lit at one place of each, given as shares (n,) of their lengths."""
    rows = _shining(slab)
    rgb, point = slab.rgb.copy(), slab.front[rows].towards(slab.back[rows], share[rows])
    lit = SHADES[setup.stages["shade"].name](setup, point, field_gradient(setup, point.p_index), to_eye[rows])
    rgb[rows] = rgb[rows] * lit.diffuse + slab.alpha[rows, None] * lit.specular
    return rgb


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray((a * b).sum(axis=1))


def _positive(cosine: FloatArray) -> FloatArray:
    return np.maximum(cosine, 0.0)


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0))


SHADES: dict[str, Callable[[Setup, Sample, FloatArray, FloatArray], Lit]] = {
    "none": none,
    "blinn_phong": blinn_phong,
    "phase": phase,
}
VISIBILITIES: dict[str, Callable[[Setup, int | None, FloatArray], FloatArray]] = {"none": no_occlusion}
LIGHTINGS: dict[str, Callable[[Setup, Slab, FloatArray], FloatArray]] = {
    "unlit": unlit,
    "sampled": sampled,
    "supersampled": supersampled,
    "averaged": averaged,
    "interpolated": interpolated,
}
