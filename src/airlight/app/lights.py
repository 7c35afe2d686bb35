"""``--light``, made into values."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import ValueRangeError
from ..geometry import Mesh
from ..light import Light
from ..scene import Layer, Scene
from .parse import assignments

OPTION = "--light"


def parse_lights(texts: Sequence[str]) -> tuple[Light, ...]:
    """Lights of ``head``, ``directional:to_light=[0,-1,1],color=white`` or ``point:position=[0,0,9],radius=5``."""
    return tuple(_parsed(text) for text in texts)


def _parsed(text: str) -> Light:
    kind, colon, rest = text.partition(":")
    values = assignments(rest, OPTION) if colon else {}
    try:
        return Light.from_dict({**values, "kind": kind.strip()})
    except ValueRangeError as error:
        raise ValueRangeError(OPTION + error.where.removeprefix("light"), error.what, error.remedy) from None


def check_lit(scene: Scene) -> None:
    """Refuse lights that nothing asks.

    Raises
    ------
    ValueRangeError
        When all layers are shaded without lights, or show values that are not lit, and so are all meshes.
    """
    shades = [layer.look.shade for layer in scene.visible_layers[:1]]
    # Meshes are lit as the first layer is; where that is not lit at all by Blinn-Phong.
    meshes_ask = all(getattr(shade, "asks_lights", True) or not getattr(shade, "lit", True) for shade in shades)
    if meshes_ask and any(isinstance(mesh, Mesh) and mesh.lit for mesh in scene.meshes):
        return
    causes = [_cause(layer) for layer in scene.layers]
    if all(causes):
        cause = causes[0] if causes else "the scene has neither volumes nor meshes that are lit"
        raise ValueRangeError(OPTION, f"lights nothing, {cause}", "leave one of them out, or use --shade blinn_phong")


def _cause(layer: Layer) -> str:
    """Why lights mean nothing to a layer; empty where they do."""
    look = layer.look
    if not getattr(look.integrate, "uses_slabs", True):
        return f"--integrate {look.integrate.name} is not lit"
    return "" if getattr(look.shade, "asks_lights", True) else f"--shade {look.shade.name} asks no lights"
