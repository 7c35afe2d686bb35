"""``--environment`` and ``--background environment``, made into values."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

from ..environment import BUILT_IN, Environment
from ..errors import ValueRangeError
from ..scene import Layer, Scene
from ..stages.environment import Environment as EnvironmentLight
from .parse import assignments

BACKGROUND = "environment"


def parse_environment(text: str, turn_deg: float | None) -> Environment:
    """Environment of ``studio``, ``sky:turbidity=4,to_sun=[1,-1,1]`` or the name of a picture, turned about the vertical."""
    name, colon, rest = text.partition(":")
    try:
        if name in BUILT_IN:
            values: dict[str, Any] = assignments(rest, "--environment") if colon else {}
            found = Environment.from_dict({"kind": name} | values)
        else:
            found = Environment.open(text)
        return found if turn_deg is None else found.turned(math.radians(turn_deg))
    except ValueRangeError as error:
        part = error.where.removeprefix("environment") if error.where.startswith("environment.") else ""
        raise ValueRangeError(f"--environment{part}", error.what, error.remedy) from None


def environment_of(option: str | None, turn_deg: float | None) -> Environment | None:
    """Environment that is asked for; None where none is.

    Raises
    ------
    ValueRangeError
        For a turn without an environment.
    """
    if option is None and turn_deg is not None:
        raise ValueRangeError("--environment-turn", "turns no environment", "give --environment")
    return None if option is None else parse_environment(option, turn_deg)


def lit_by(layer: Layer, environment: Environment | None, shade_given: bool) -> Layer:
    """Return the layer lit by an environment; a stage of another kind that was asked for stays."""
    shade = layer.look.shade
    if environment is None or (shade_given and not isinstance(shade, EnvironmentLight)):
        return layer
    is_light = isinstance(shade, EnvironmentLight)
    light = dataclasses.replace(shade, environment=environment) if is_light else EnvironmentLight(environment)  # type: ignore[type-var]
    return dataclasses.replace(layer, look=dataclasses.replace(layer.look, shade=light))


def check_lights(layers: Sequence[Layer], shade: str | None) -> None:
    """Refuse an environment that is not seen and lights no layer.

    Raises
    ------
    ValueRangeError
        When all layers are lit by other stages, or show values that are not lit.
    """
    lit = [layer for layer in layers if isinstance(layer.look.shade, EnvironmentLight)]
    if any(getattr(layer.look.integrate, "uses_slabs", True) for layer in lit):
        return
    cause = f"--integrate {lit[0].look.integrate.name} is not lit" if lit else f"--shade is {shade}"
    raise ValueRangeError("--environment", f"lights nothing, {cause}", "leave it out, or add --background environment")


def seen_behind(scene: Scene, environment: Environment | None) -> Environment:
    """Environment for ``--background environment``: the one that is asked for, else the one that lights the scene.

    Raises
    ------
    ValueRangeError
        When there is none.
    """
    if environment is not None:
        return environment
    for layer in scene.layers:
        if isinstance(layer.look.shade, EnvironmentLight):
            return layer.look.shade.environment
    raise ValueRangeError("--background", "asks for an environment, and nothing is lit by one", "add --environment studio")
