"""``airlight demo``: a sample volume, fetched and rendered."""

import time
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .. import samples
from ..first_picture import first_picture
from .options import VIEW
from .parse import parse_size
from .progress import ProgressBar
from .render import check_output

# Half a voxel: light is evaluated once a slab, and whole voxels of 2 mm leave faint rings on smooth skin.
STEP = 0.5


def demo(
    *,
    sample: Annotated[
        str, Parameter(metavar="NAME", help=f"One of {', '.join(samples.names())}; mni-head unless told.")
    ] = "mni-head",
    output: Annotated[
        str, Parameter(name=["--output", "-o"], metavar="FILE", help="Where the picture is written; demo.png unless told.")
    ] = "demo.png",
    size: Annotated[
        str, Parameter(group=VIEW, metavar="WxH", help="Width and height in pixels; 1024x1024 unless told.")
    ] = "1024x1024",
    device: Annotated[str | None, Parameter(metavar="NAME", help="Adapter, by a part of its name or kind.")] = None,
) -> None:
    """Fetch a sample volume, choose a good first picture of it, and render it, shaded.

    For instance:

        airlight demo
        airlight demo --sample fly -o fly.png
    """
    from .. import api

    check_output(output)
    size_px = parse_size(size)
    print(samples.describe(sample), flush=True)
    with ProgressBar() as progress:
        volume = samples.load(sample, progress=progress)
        started = time.perf_counter()
        image = api.render(first_picture(volume, size_px), size_px, step=STEP, device=device, progress=progress)
        seconds = time.perf_counter() - started
    image.save(output)
    adapter = image.stats.get("adapter", {})
    name = adapter.get("name", "") if isinstance(adapter, dict) else str(adapter)
    print(f"{size_px[0]}x{size_px[1]} in {seconds:.1f} s on {name}")
    print(f"the picture is {Path(output).absolute()}")
