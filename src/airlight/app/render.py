"""``airlight render``: a volume or a scene to an image."""

import json
import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..errors import FileError
from .build import make_job
from .options import DrawOptions, LookOptions, ReadOptions, ViewOptions
from .progress import ProgressBar

ENDINGS = (".png", ".exr", ".npy")


def render(
    input: Annotated[str, Parameter(help="A volume (file or folder) or a scene (.toml).")],
    /,
    *,
    output: Annotated[
        str,
        Parameter(
            name=["--output", "-o"],
            metavar="FILE",
            allow_leading_hyphen=True,
            help="A .png, .exr or .npy file; - for PNG to standard output.",
        ),
    ],
    look: LookOptions | None = None,
    view: ViewOptions | None = None,
    draw: DrawOptions | None = None,
    read: ReadOptions | None = None,
    stats: Annotated[
        str | None,
        Parameter(
            metavar="[FILE.json]",
            allow_leading_hyphen=True,
            help="Write adapter, samples, times and errors as JSON to a .json file, or to standard error.",
        ),
    ] = None,
    save_scene: Annotated[
        str | None,
        Parameter(metavar="FILE.toml", help="Also write what was drawn as a scene file, to be rendered again or changed."),
    ] = None,
) -> None:
    """Render a volume or a scene to an image.

    What is not said is chosen from the data. For instance:

        airlight render head.nii.gz -o head.png
        airlight render ct.nrrd -o bone.png --preset ct-bone --camera iso --size 1024x1024
        airlight render ct.nrrd -o skin.png --tf "-200:#e2ac8b:0 100:#f0c8ac:0.4" --shade blinn_phong:shininess=40
        airlight render cells.ome.tif -o cells.png --channel 1 --integrate mip --background black
        airlight render foot.raw -o foot.png --shape 256x256x256 --dtype uint8 --spacing 1,1,1
        airlight render scene.toml -o - --stats | display
    """
    check_output(output)
    with ProgressBar() as progress:
        job = make_job(
            input, look or LookOptions(), view or ViewOptions(), draw := draw or DrawOptions(), read or ReadOptions(), progress
        )
        from .. import api

        image = api.render(job.scene, job.size, device=draw.device, progress=progress, **job.arguments)
    if save_scene is not None:
        from ..scene_file import save_scene as write_scene

        write_scene(job.scene, save_scene, render={"size": job.size} | job.arguments)
    if output == "-":
        sys.stdout.buffer.write(image.png())
        sys.stdout.buffer.flush()
    else:
        image.save(output)
    if stats is not None:
        write_stats(image.stats, stats)


def check_output(output: str) -> None:
    """Refuse what could not be written before anything is computed."""
    if output == "-":
        if sys.stdout.isatty():
            raise FileError("-o -", "would write a PNG file to the terminal", "name a file, or pipe it on")
        return
    path = Path(output)
    if path.suffix.lower() not in ENDINGS:
        raise FileError(output, "has no ending that says what to write", f"use one of {', '.join(ENDINGS)}, or -")
    if not path.absolute().parent.is_dir():
        raise FileError(output, "cannot be written, its folder is not there", f"make {path.parent}")


def write_stats(stats: dict[str, Any], target: str) -> None:
    """Write statistics as JSON to a file, or to standard error for ``-``."""
    text = json.dumps(stats, indent=2, default=plain) + "\n"
    if target == "-":
        sys.stderr.write(text)
        return
    from ..io.paths import replacing

    with replacing(Path(target)) as temporary:
        temporary.write_text(text, encoding="utf-8")


def plain(value: Any) -> Any:
    """Numbers of NumPy as Python's, anything else as text."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
