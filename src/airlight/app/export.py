"""``airlight export``: a volume or a scene to one page that any browser with WebGPU draws."""

import sys
from dataclasses import replace
from typing import Annotated

from cyclopts import Group, Parameter

from ..errors import FileError, ValueRangeError
from ..pages.exporting import SIZE, VOXELS, checked_target
from .build import make_job
from .inputs import SCENE_INPUT
from .options import DrawOptions, LookOptions, ReadOptions, ViewOptions
from .progress import ProgressBar

PAGE = Group("Page", sort_key=0)
TAKEN = ("driver", "step", "skip")


def export(
    input: Annotated[str, Parameter(help=SCENE_INPUT)],
    /,
    *,
    output: Annotated[
        str,
        Parameter(
            name=["--output", "-o"], metavar="FILE.html", allow_leading_hyphen=True, help="The page, a single .html file."
        ),
    ],
    voxels: Annotated[
        str,
        Parameter(
            group=PAGE,
            metavar="N",
            help=f"Most voxels along an axis, 2 to 512; larger volumes are averaged. {VOXELS} unless told; all keeps them.",
        ),
    ] = str(VOXELS),
    bits: Annotated[int | None, Parameter(group=PAGE, help="8 or 16 of a value; as the data ask for unless told.")] = None,
    title: Annotated[str, Parameter(group=PAGE, help="Heading of the page; none unless told.")] = "",
    look: LookOptions | None = None,
    view: ViewOptions | None = None,
    draw: DrawOptions | None = None,
    read: ReadOptions | None = None,
) -> None:
    """Write a page to send: a volume to be turned, and its transfer function edited, in any browser with WebGPU.

    The file holds all that it needs, and of the volume's file nothing but samples, geometry and units. For instance:

        airlight export head.nii.gz -o head.html --title "A head"
        airlight export ct.nrrd -o bone.html --preset ct-bone --camera iso --voxels 192
        airlight export ct.nrrd -o small.html --voxels 96 --bits 8
        airlight export scene.toml -o scene.html
    """
    if output == "-":
        raise FileError("-o -", "would write to standard output, and a page is a file", "name one that ends in .html")
    checked_target(output)
    most = _voxels(voxels)
    view, draw = view or ViewOptions(), draw or DrawOptions()
    if view.size is None:
        view = replace(view, size=f"{SIZE[0]}x{SIZE[1]}")
    with ProgressBar() as progress:
        job = make_job(input, look or LookOptions(), view, draw, read or ReadOptions(), progress)
        for name in job.arguments.keys() - set(TAKEN):
            option = {"budget_ms": "budget", "passes": "pass"}.get(name, name)
            raise ValueRangeError(f"--{option}", "is given, and a page draws every picture in the same way", "leave it out")
        from ..pages import export as write

        chosen = {name: job.arguments[name] for name in ("driver", "step") if name in job.arguments}
        told = write(
            job.scene,
            output,
            size=job.size,
            voxels=most,
            bits=bits,
            title=title,
            device=draw.device,
            progress=progress,
            **chosen,
        )
    for note in told.notes:
        print(f"note: {note}", file=sys.stderr)


def _voxels(text: str) -> int | None:
    if text == "all":
        return None
    if not text.isdecimal():
        raise ValueRangeError("--voxels", f"is {text!r}, must be a whole number or all")
    return int(text)
