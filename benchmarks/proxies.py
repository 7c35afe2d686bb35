"""Proxy geometry on the host: slices, pieces, stripes and shells of a box of 256 voxels a side, seen from a corner.

*slices*: by scan-plane coherence; *plain clipping*: the same, each slice cut out of the box by itself, as the yardstick of the
tests does. *pieces*: closed surfaces between neighbouring slices. *shell covers*: the same between spheres round the eye.
*stripes*: slices, one a voxel, cut at the layers of one stack. *object stripes*: the like of object-aligned slices. *shells*:
tessellated spheres, a hundred in all, within a quarter of a voxel. Times are those of this process by the processor's clock.
Bar: 1,000 slices in 10 ms.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from common import arguments, machine, parsed, side_by_side, spread, table, write_json

from airlight.rendering.proxies.pieces import pieces_of
from airlight.rendering.proxies.planes import slices_of
from airlight.rendering.proxies.polyhedra import box, clipped
from airlight.rendering.proxies.shells import in_frustum, shell_pieces, shells_of
from airlight.rendering.proxies.stripes import object_stripes, stripes_of

MOST_MS = 10.0
SIDE = 256
VIEW = np.array([1.0, 2.0, 3.0]) / np.sqrt(14)


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when the bar is missed."""
    parser = arguments(__doc__, "proxies", repeats=15)
    parser.add_argument("--slices", type=int, default=1000, help="slices and pieces of the box (default: %(default)s)")
    options = parsed(parser, argv, repeats=1, slices=40)
    results = machine() | {"quick": options.quick, "slices": options.slices}
    jobs = jobs_of(options.slices, 16 if options.quick else SIDE)
    rows = []
    for name, measured in side_by_side(jobs, options.repeats).items():
        what, count = measured.result
        rows.append({"geometry": name, "made of it": f"{count:,} {what}"} | in_ms(measured.cpu))
    print(table(rows))
    passes = bool(rows[0]["ms"] <= MOST_MS)
    print(f"\n{'PASS' if passes else 'FAIL'}: {options.slices:,} slices may take {MOST_MS:g} ms")
    write_json(options.out, results | {"rows": rows, "passes": passes})
    return 0 if passes or options.quick else 1


def jobs_of(count: int, side: int) -> dict[str, Any]:
    """Jobs that return what they count and how many they made."""
    whole = box(np.zeros(3), np.full(3, side - 1.0), np.eye(4))
    heights = whole.vertices @ VIEW
    offsets = np.linspace(heights.min(), heights.max(), count + 2)[1:-1]
    layers, voxels = np.arange(float(side)), np.arange(heights.min(), heights.max())
    eye = whole.vertices.mean(axis=0) - 1.5 * side * VIEW
    distances = np.linalg.norm(whole.vertices - eye, axis=1)
    radii = np.linspace(0.5 * distances.min(), distances.max(), count)
    seen = in_frustum(whole, eye, frustum(np.tan(np.radians(30))))

    def plain() -> tuple[str, int]:
        lids = [clipped(whole, VIEW, float(offset)).faces[-1] for offset in offsets]
        return "vertices", sum(map(len, lids))

    def stripes() -> tuple[str, int]:
        return "stripes", len(stripes_of(whole, VIEW, voxels, (0, 0, 1), layers))

    def rectangles() -> tuple[str, int]:
        return "stripes", len(object_stripes(np.zeros(3), np.full(3, side - 1.0), np.eye(4), 0, layers, 2, side))

    return {
        "slices": lambda: ("vertices", len(slices_of(whole, VIEW, offsets).vertices)),
        "slices by plain clipping": plain,
        "pieces": lambda: ("triangles", len(pieces_of(whole, VIEW, offsets).corners)),
        "shell covers": lambda: ("triangles", len(shell_pieces(whole, eye, radii).corners)),
        "stripes": stripes,
        "object stripes": rectangles,
        "shells": lambda: ("polygons", len(shells_of(seen, eye, radii[:: max(len(radii) // 100, 1)], 0.25).polygons)),
    }


def frustum(tangent: float) -> np.ndarray:
    """Directions (4, 3) of the corners of a square image round the view."""
    right = np.cross(VIEW, (0, 0, 1))
    right /= np.linalg.norm(right)
    up = np.cross(right, VIEW)
    return np.array([VIEW + tangent * (x * right + y * up) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


def in_ms(seconds: list[float]) -> dict[str, float]:
    found = spread(1e3 * np.array(seconds))
    return {"ms": found["median"], "least": found["min"], "greatest": found["max"]}


if __name__ == "__main__":
    sys.exit(main())
