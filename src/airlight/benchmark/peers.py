"""VTK's mappers on the scenes that it has, in a process of its own: where it cannot draw it may end the process.

Each is compared with its own picture at an eighth of a voxel, since lit scenes do not mean quite the same in both.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from dataclasses import asdict
from typing import Any

from .measure import errors, side_by_side, spread
from .suite import CONVERGED_STEP, STEPS, Plan, cases

LONGEST_SECONDS = 300.0
"""Time that VTK may take beside what is timed."""


def vtk_is_there() -> bool:
    """Whether VTK is installed."""
    return importlib.util.find_spec("vtkmodules") is not None


def vtk_rows(plan: Plan) -> list[dict[str, Any]]:
    """Time and error of VTK's mappers as ``suite.measured`` gives them; one row that tells why where they cannot be had."""
    command = [sys.executable, "-m", __name__, json.dumps(asdict(plan))]
    longest = LONGEST_SECONDS + plan.seconds
    try:
        done = subprocess.run(command, capture_output=True, timeout=longest, check=False)
    except subprocess.TimeoutExpired:
        return [_failed(f"took more than {longest:.0f} seconds")]
    if done.returncode != 0:
        last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        return [_failed(f"ended with code {done.returncode}: {''.join(last)}")]
    rows: list[dict[str, Any]] = json.loads(done.stdout.decode().splitlines()[-1])
    return rows


def _failed(why: str) -> dict[str, Any]:
    return {"scene": "all", "renderer": "VTK", "failed": why}


def measured_in_vtk(plan: Plan) -> list[dict[str, Any]]:
    """Time and error of VTK's mappers, drawn in this process."""
    from .vtk_side import mappers_of, vtk_picture

    known = {name: case.scene for name, case in cases(plan.voxels).items() if case.in_vtk}
    pairs = sum(len(mappers_of(scene)) for scene in known.values())
    rows = []
    for name, scene in known.items():
        for label, mapper in mappers_of(scene).items():
            small, large = (vtk_picture(scene, size, mapper) for size in (plan.error_size_px, plan.size_px))
            truth = small.draw(CONVERGED_STEP)
            jobs = {str(step): (lambda step=step, large=large: large.draw(step)) for step in STEPS}
            timed = side_by_side(jobs, plan.repeats, seconds=plan.seconds / pairs)
            for step in STEPS:
                total = spread([1e3 * seconds for seconds in timed[str(step)].wall])
                row = {"scene": name, "renderer": label, "step": step, "milliseconds": {"total": total}}
                rows.append(row | {"error": errors(small.draw(step), truth)})
            small.close()
            large.close()
    return rows


if __name__ == "__main__":
    given = json.loads(sys.argv[1])
    sizes = {name: (given[name][0], given[name][1]) for name in ("size_px", "error_size_px")}
    sys.stdout.write("\n" + json.dumps(measured_in_vtk(Plan(**(given | sizes)))) + "\n")
