"""Projections: sums without attenuation, and maxima that tell what is near. See ``integrate.py`` for their functions."""

from __future__ import annotations

import numpy as np

from ..stages.camera import Orthographic
from ..transfer.attenuation import greatest_depth
from ..volume import FloatArray
from .integrate import INTEGRATES, Accumulated, Integrate
from .setup import BoolArray, IntArray, Slab
from .transfer import colour

SHARES = np.linspace(0.0, 1.0, 65)
"""Places within a slab, from front to back, at which strengths are compared."""


class Sum(Integrate):
    """What thinned slabs hold, added up and multiplied by what they were divided by; alpha tells whether there was any."""

    uses_slabs = True

    def deepest(self, of_source: bool = False) -> float:
        """Depth of the data by the function as it was before it was thinned."""
        layer, whole = self.setup.layer, self.setup.function.scaled(1 / self.stage.thinned)
        return greatest_depth(layer.volume, whole, self.setup.channels[0], layer.time, of_source=of_source)


class WeightedSum(Sum):
    """Colour times extinction along the ray."""

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Add the slab's light."""
        acc.rgb[rays] += slab.rgb / self.stage.thinned
        acc.alpha[rays] = 1.0
        return np.zeros(len(rays), dtype=bool)

    def finish(self, acc: Accumulated) -> Accumulated:
        """Show the full sum as 1."""
        acc.rgb /= self.deepest(of_source=True) if self.stage.full is None else self.stage.full
        return acc


class XRay(Sum):
    """Optical depth along the ray, or what it lets through."""

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Add the slab's depth."""
        acc.value[rays] -= np.log1p(-np.minimum(slab.alpha, 1 - 1e-12)) / self.stage.thinned
        acc.alpha[rays] = 1.0
        return np.zeros(len(rays), dtype=bool)

    @np.errstate(under="ignore")
    def finish(self, acc: Accumulated) -> Accumulated:
        """Map the window to black and white."""
        low, high, depth = self.stage.low, self.stage.high, acc.value
        if self.stage.show == "transmission":
            end = 0.0 if high is None else np.exp(-high)
            shown = (np.exp(-depth) - end) / (np.exp(-low) - end)
        else:
            shown = (depth - low) / (self.deepest() if high is None else high - low)
        acc.rgb = (np.maximum(shown, 0.0) * acc.alpha)[:, None] * np.ones(3)
        return acc


class Strongest(Integrate):
    """Keep the place whose strength times brightness is greatest, the first of equal ones, of many places in each slab."""

    def brightness(self, acc: Accumulated, rays: IntArray, slab: Slab, strength: FloatArray) -> FloatArray:
        """Brightness (n, places) of places at shares of a slab."""
        raise NotImplementedError

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Compare all places of the slab."""
        (first, last), n = self.setup.function.domain, len(rays)
        value = slab.front.value[:, None] + SHARES * (slab.back.value - slab.front.value)[:, None]
        strength = np.clip((value - first) / (last - first), 0.0, 1.0)
        brightness = self.brightness(acc, rays, slab, strength)
        best = (strength * brightness).argmax(axis=1)
        at = np.arange(n), best
        reached = strength[at] * brightness[at]
        better = (acc.alpha[rays] == 0) | (reached > acc.value[rays])
        here = slab.front.towards(slab.back, SHARES[best])[better]
        chosen = rays[better]
        acc.value[chosen], acc.t_world[chosen], acc.alpha[chosen] = reached[better], here.t_world, 1.0
        acc.rgb[chosen] = colour(self.setup, here) * brightness[at][better, None]
        return np.zeros(n, dtype=bool)


class AttenuatedMip(Strongest):
    """Brightness is what the values in front let through."""

    @np.errstate(under="ignore")
    def brightness(self, acc: Accumulated, rays: IntArray, slab: Slab, strength: FloatArray) -> FloatArray:
        """Attenuate by the trapezoid rule along the slab, and keep the depth of all of it."""
        volume = self.setup.layer.volume
        sides = [n * s for n, s in zip(volume.size, volume.spacing, strict=True)]
        full = 20.0 / max(sides) if self.stage.attenuation is None else self.stage.attenuation
        pieces = (strength[:, 1:] + strength[:, :-1]) / 2 * (full * slab.length / (len(SHARES) - 1))[:, None]
        depth = acc.length[rays, None] + np.concatenate([np.zeros((len(rays), 1)), pieces.cumsum(axis=1)], axis=1)
        acc.length[rays] = depth[:, -1]
        return np.asarray(np.exp(-depth))


class DepthShadedMip(Strongest):
    """Brightness falls with distance from the eye."""

    def brightness(self, acc: Accumulated, rays: IntArray, slab: Slab, strength: FloatArray) -> FloatArray:
        """Fall straight from near to far."""
        corners, camera = self.setup.layer.volume.corners_world(), self.setup.camera
        middle = corners.mean(axis=0)
        reach = np.linalg.norm(corners - middle, axis=1).max()
        way = middle - np.array(camera.eye)
        away = way @ camera.basis()[2] if isinstance(camera, Orthographic) else np.linalg.norm(way)
        near = max(away - reach, 0.0) if self.stage.near is None else self.stage.near
        far = away + reach if self.stage.far is None else self.stage.far
        t_world = slab.front.t_world[:, None] + SHARES * (slab.back.t_world - slab.front.t_world)[:, None]
        return np.asarray(1 - (1 - self.stage.darkest) * np.clip((t_world - near) / (far - near), 0.0, 1.0))


class LocalMip(Integrate):
    """Keep the greatest value until it has reached the threshold and values have fallen behind it."""

    def take(self, acc: Accumulated, rays: IntArray, slab: Slab) -> BoolArray:
        """Look at both ends of the slab, one after the other."""
        told, ended = self.stage.threshold, np.zeros(len(rays), dtype=bool)
        threshold = self.setup.function.half_extinction_value if told is None else told
        for end in (slab.front, slab.back):
            kept, met = acc.value[rays], acc.alpha[rays] > 0
            ended |= met & (kept >= threshold) & (end.value < kept - self.stage.drop)
            better = ~ended & (~met | (end.value > kept))
            chosen = rays[better]
            acc.value[chosen], acc.t_world[chosen], acc.alpha[chosen] = end.value[better], end.t_world[better], 1.0
            acc.rgb[chosen] = colour(self.setup, end[better])
        return ended


INTEGRATES |= {
    "weighted_sum": WeightedSum,
    "xray": XRay,
    "attenuated_mip": AttenuatedMip,
    "depth_shaded_mip": DepthShadedMip,
    "local_mip": LocalMip,
}
