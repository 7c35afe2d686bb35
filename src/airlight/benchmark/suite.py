"""The fixed set of scenes, and how time and error of each are measured.

Times are of pictures as large as asked. Errors are of smaller ones, of the same view: against the picture that converged, so
that what they take is bounded.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from .. import samples
from ..errors import AirlightError
from ..light import Light
from ..scene import Look, Scene, fit_camera
from ..stages.integrate import FirstHit
from ..stages.transfer import PostClassified
from ..transfer import TransferFunction
from ..volume import Volume
from .measure import errors, side_by_side, spread
from .scenes import bone, flow, haze, head, noisy_cloud, shells, stand_in

STEPS = (2.0, 1.0, 0.5)
CONVERGED_STEP = 1 / 8
OURS, ENDS_ALONE = "airlight", "airlight, post-classified"

Told = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Plan:
    """How much is measured.

    Attributes
    ----------
    size_px, error_size_px
        Width and height of the pictures whose time is taken, and of those that are compared.
    voxels
        Voxels along each axis of the computed volumes.
    repeats
        Most pictures of a scene and step that count.
    seconds
        Time for the pictures that are timed, of all scenes together; each is drawn once at least.
    """

    size_px: tuple[int, int] = (512, 512)
    error_size_px: tuple[int, int] = (160, 160)
    voxels: int = 128
    repeats: int = 5
    seconds: float = 30.0


@dataclass(frozen=True)
class Case:
    """A scene, and whether VTK has one that means the same."""

    scene: Scene
    in_vtk: bool = False

    @cached_property
    def ways(self) -> dict[str, Scene]:
        """The scene by who draws it: as it is, and where slabs are integrated also by the media of their two ends alone."""
        (layer,) = self.scene.layers
        if not getattr(layer.look.integrate, "classifies", False):
            return {OURS: self.scene}
        ends_alone = replace(layer, look=replace(layer.look, transfer=PostClassified()))
        return {OURS: self.scene, ENDS_ALONE: replace(self.scene, layers=(ends_alone,))}


def cases(voxels: int) -> dict[str, Case]:
    """Scenes by name: solid and translucent, full and empty, with light and without, and the other ways to look along a ray."""
    body, rings = stand_in(voxels), shells(voxels)
    speed, cloud = samples.load("vortex", size=voxels), noisy_cloud(voxels)
    layered = TransferFunction([(100, "#204060", 0.0), (180, "#e08040", 0.02), (255, "white", 0.3)])
    return {
        "head, lit": Case(_scene(body, head(), Look()), in_vtk=True),
        "bone, unlit": Case(_scene(body, bone(), Look(shade="none")), in_vtk=True),
        "flow, unlit": Case(_scene(speed, flow(), Look(shade="none"))),
        "cloud, nowhere empty": Case(_scene(cloud, haze(cloud), Look(shade="none")), in_vtk=True),
        "shells, surface": Case(_scene(rings, layered, Look(integrate=FirstHit(iso=200.0))), in_vtk=True),
        "shells, maximum": Case(_scene(rings, layered, Look(integrate="mip"))),
    }


def _scene(volume: Volume, function: TransferFunction, look: Look) -> Scene:
    camera = fit_camera("iso", volume.corners_world(), 1.0)
    # VTK's head light shines along the view.
    lights = [Light.directional(to_light=tuple(np.subtract(camera.eye, camera.target)))]
    return Scene(volume, transfer=function, look=look, camera=camera, lights=lights)


def measured(
    renderer: Any, plan: Plan, told: Told, clock: Callable[[], float] = time.perf_counter
) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """The adapter, and time and error of each scene at each step; a scene that cannot be drawn has an entry ``failed``.

    Raises
    ------
    AirlightError
        That of the last scene, when none can be drawn.
    """
    rows: list[dict[str, Any]] = []
    adapter: dict[str, Any] = {}
    known = cases(plan.voxels)
    for number, (name, case) in enumerate(known.items()):
        told("scenes", number, len(known))
        try:
            found, adapter = _rows_of(renderer, name, case, plan, plan.seconds / len(known), clock)
        except AirlightError as error:
            if not adapter and number == len(known) - 1:
                raise
            found = [{"scene": name, "renderer": OURS, "failed": str(error)}]
        rows += found
    told("scenes", len(known), len(known))
    return adapter, rows


def _rows_of(
    renderer: Any, name: str, case: Case, plan: Plan, seconds: float, clock: Callable[[], float]
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    truth = renderer.render(case.scene, plan.error_size_px, step=CONVERGED_STEP, skip="none").rgba
    frames: dict[tuple[str, float], list[dict[str, Any]]] = {(way, step): [] for way in case.ways for step in STEPS}

    def drawing(way: str, step: float) -> Callable[[], None]:
        return lambda: frames[way, step].append(renderer.render(case.ways[way], plan.size_px, step=step).stats)

    jobs = {f"{way} {step}": drawing(way, step) for way, step in frames}
    timed = side_by_side(jobs, plan.repeats, seconds=seconds, clock=clock)
    rows = []
    for way, step in frames:
        counted = frames[way, step][-len(timed[f"{way} {step}"].wall) :]
        drawn = renderer.render(case.ways[way], plan.error_size_px, step=step).rgba
        passes = {
            key: spread([frame["milliseconds"].get(key, 0.0) for frame in counted]) for key in counted[-1]["milliseconds"]
        }
        rows.append(
            {
                "scene": name,
                "renderer": way,
                "step": step,
                "milliseconds": passes,
                "samples": counted[-1]["samples"],
                "samples_a_pixel": counted[-1]["samples"] / math.prod(plan.size_px),
                "error": errors(drawn, truth),
            }
        )
    return rows, counted[-1]["adapter"]
