"""Programs that edits of a transfer function will ask for, compiled before anybody waits for them.

A program leaves out what a function does not need: the search for a cell where all are equally wide, what lies beyond the ends
where nothing does, the look at empty stretches where there are none; and where no table of slabs is accurate it has none. A
dragged control point may change any of these. Drivers finish programs at their first dispatch, so that there is no way but to
draw with them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ..scene import Scene
from ..transfer import TransferFunction

UNEVEN = 0.381966011  # of the axis: the golden section keeps farthest from the borders of any number of even cells
OPAQUE = 1e6  # between steps of that no table of slabs is accurate


def neighbours(function: TransferFunction) -> list[TransferFunction]:
    """Functions on the same axis, one of each kind that control points may be dragged to, without steps at the ends."""
    first, last = function.domain
    last = last if last > first else first + 1.0

    def kind(ends: float, stretch: bool, even: bool, steep: bool = False) -> TransferFunction:
        inside = [(0.25, 0.0), (0.5, 0.0), (0.75, 0.1)] if stretch else [(0.5, 0.1)]
        places = [(0.0, ends), *inside, (1.0, ends)]
        places += [] if even else [(UNEVEN, 0.0 if stretch else 0.05)]
        places += [(0.9, 0.05), (0.9, OPAQUE)] if steep else []
        points = [(first + u * (last - first), (1.0, 1.0, float(tau < 1)), tau) for u, tau in sorted(places)]
        return TransferFunction(points, function.associated, function.surfaces)

    kinds = ((0.1, False), (0.1, True), (0.0, True))
    found = [kind(ends, stretch, even) for ends, stretch in kinds for even in (True, False)]
    return [*found, *(kind(ends, stretch, even=False, steep=True) for ends, stretch in kinds)]


def scenes_near(scene: Scene) -> Iterator[Scene]:
    """Scenes that differ by the functions of their layers, as edits may make them, the scene itself first."""
    yield scene
    for number, layer in enumerate(scene.layers):
        if layer.visible and isinstance(layer.transfer, TransferFunction):
            for function in neighbours(layer.transfer):
                layers = list(scene.layers)
                layers[number] = replace(layer, transfer=function)
                yield replace(scene, layers=tuple(layers))
