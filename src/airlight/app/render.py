"""``airlight render``: a volume or a scene to an image."""

import itertools
import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter

from ..errors import FileError, ValueRangeError
from ..files import write_text, written
from ..scene import VIEWS, Scene
from ..volume import Volume, statistics
from .build import is_scene, make_job
from .inputs import SCENE_INPUT
from .labels import LabelOptions, label_notes
from .options import DrawOptions, LookOptions, ReadOptions, ViewOptions
from .progress import ProgressBar

ENDINGS = (".png", ".exr", ".npy")
BESIDE_ENDINGS = (".png", ".npy")


def render(
    input: Annotated[str, Parameter(help=SCENE_INPUT)],
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
    labels: LabelOptions | None = None,
    stats: Annotated[
        str | None,
        Parameter(
            metavar="[FILE.json]",
            allow_leading_hyphen=True,
            help="Write adapter, samples, times and errors as JSON to a .json file, or to standard error.",
        ),
    ] = None,
    normals: Annotated[
        str | None,
        Parameter(
            metavar="FILE",
            help="Also write normals, of surfaces (--integrate first_hit) or where opacity passes one half: .npy, or .png with "
            "0.5 + 0.5 n as colours.",
        ),
    ] = None,
    disagreement: Annotated[
        str | None,
        Parameter(
            metavar="FILE",
            help="Also write how far neighbouring offsets disagree (--offsets interleaved), a sign that the step is too large: "
            ".npy, or .png with the picture in grey under it.",
        ),
    ] = None,
    dither: Annotated[
        bool,
        Parameter(negative="", help="Fine noise instead of bands where colours change slowly, in the 8 bits of .png."),
    ] = False,
    half: Annotated[bool, Parameter(negative="", help="Colours and opacity of .exr in 16 bits instead of 32.")] = False,
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
        airlight render tooth.nrrd -o tooth.png --auto boundaries2d
        airlight render cells.ome.tif -o cells.png --channel 1 --integrate mip --background black
        airlight render cells.ome.tif -o mixture.png --channels 0=green,1=magenta
        airlight render head.nii.gz -o brain.png --labels atlas.nii.gz --label-names atlas.txt --hide-labels 0
        airlight render mni-head -o mri.png --preset mri --light head:intensity=0.4 --light "directional:to_light=[-1,-1,2]"
        airlight render foot.raw -o foot.png --shape 256x256x256 --dtype uint8 --spacing 1,1,1
        airlight render ct.nrrd -o exact.png --tolerance 0.004
        airlight render scene.toml -o - --stats | display
    """
    check_output(output)
    check_options(output, dither, half)
    if normals is not None:
        check_beside("--normals", normals, output)
    if disagreement is not None:
        check_beside("--disagreement", disagreement, output)
    with ProgressBar() as progress:
        job = make_job(
            input,
            look or LookOptions(),
            view or ViewOptions(),
            draw := draw or DrawOptions(),
            read or ReadOptions(),
            progress,
            labels,
        )
        if disagreement is not None and getattr(job.arguments.get("driver"), "offsets", "none") != "interleaved":
            raise ValueRangeError("--disagreement", "is that of interleaved offsets", "add --offsets interleaved")
        for name, option in (("tolerance", "--tolerance"), ("budget_ms", "--budget")):
            if disagreement is not None and name in job.arguments:
                raise ValueRangeError("--disagreement", f"is that of one step, and {option} chooses several", "give --step")
        from .. import api

        arguments = job.arguments if normals is None else {**job.arguments, "keep_hits": True}
        image = api.render(job.scene, job.size, device=draw.device, progress=progress, **arguments)
    if stats != "-":
        own = not is_scene(input) and (look is None or (look.channel is None and look.channels is None))
        told = notes(job.scene, image, chosen=view is None or view.camera is None, own_channel=own)
        asked = () if labels is None else label_notes(job.scene.layers[0], labels)
        for note in itertools.chain(told, asked):
            print(f"note: {note}", file=sys.stderr)
    if output == "-":
        sys.stdout.buffer.write(image.png(dither=dither))
        sys.stdout.buffer.flush()
    else:
        image.save(output, dither=dither, half=half)
    if normals is not None:
        write_normals(image.normal, Path(normals))
    if disagreement is not None:
        write_disagreement(image, Path(disagreement))
    if save_scene is not None:
        from ..scene_file import save_scene as write_scene

        kept = {key: value for key, value in job.arguments.items() if key != "budget_ms"}  # of this machine
        write_scene(job.scene, save_scene, render={"size": job.size} | kept)
    if stats is not None:
        write_stats(image.stats, stats)


def notes(scene: Scene, image: Any, chosen: bool, own_channel: bool = False) -> Iterator[str]:
    """Tell what a user might not expect: channels left out, a view against the file's axes, labels elsewhere, and nothing.

    And what was not reached: a tolerance, the whole size.
    """
    if image.stats.get("tolerance", {}).get("pixels_over"):
        yield image.stats["tolerance"]["stopped"]
    if image.stats.get("budget", {}).get("scale", 1.0) < 1:
        yield f"drawn at {image.stats['budget']['scale']:g} of the size and enlarged, to keep --budget"
    if not scene.layers:
        if not image.rgba.any():
            yield "nothing is visible: see --camera"
        return
    layer = scene.layers[0]
    if own_channel and layer.volume.channel_count > 1 and len(layer.channels) == 1:
        yield f"this is channel 0 of {layer.volume.channel_count}; --channel N draws another, --channels all draws all in one"
    if chosen and layer.volume.anatomical and not isinstance(scene.camera, str):
        to_eye = np.subtract(scene.camera.eye, scene.camera.target)
        seen = max(VIEWS, key=lambda view: float(np.dot(to_eye, VIEWS[view][0]) / np.linalg.norm(VIEWS[view][0])))
        if seen not in ("front", "iso"):
            yield f"by the file's axes this is the {seen} view, chosen from the data; --camera chooses another"
    if layer.labels is not None and _lie_apart(layer.volume, layer.labels.volume):
        yield "the labels lie outside of the image: airlight info FILE tells where each of them lies"
    if "reason" in image.stats:
        yield f"nothing is visible: {image.stats['reason']}"
    elif not image.rgba.any():
        known = statistics(layer.volume, layer.channel, layer.time)
        yield f"nothing is visible: the data run from {known.minimum:g} to {known.maximum:g}; see --tf, --preset and --camera"


def _lie_apart(one: Volume, other: Volume) -> bool:
    corners = [volume.corners_world(cells=True) for volume in (one, other)]
    (low, high), (other_low, other_high) = ((c.min(axis=0), c.max(axis=0)) for c in corners)
    return bool(np.any((low > other_high) | (other_low > high)))


def check_output(output: str, endings: tuple[str, ...] = ENDINGS) -> None:
    """Refuse what could not be written before anything is computed."""
    if output == "-":
        if sys.stdout.isatty():
            raise FileError("-o -", "would write a PNG file to the terminal", "name a file, or pipe it on")
        return
    path = Path(output)
    if path.is_dir():
        raise FileError(output, "is a folder", "name a file in it")
    if path.suffix.lower() not in endings:
        raise FileError(output, "has no ending that says what to write", f"use one of {', '.join(endings)}, or -")
    if not path.absolute().parent.is_dir():
        raise FileError(output, "cannot be written, its folder is not there", f"make {path.parent}")


def check_options(output: str, dither: bool, half: bool) -> None:
    """Refuse options that mean nothing to the kind of file, and a kind for which a package is missing."""
    if dither or half or output.lower().endswith(".exr"):
        from ..rendering.image import check_file_options

        check_file_options(Path("-.png" if output == "-" else output), dither, half)


def check_beside(option: str, file: str, output: str) -> None:
    """Refuse a file beside the picture that could not be written, or would take its place."""
    if file == "-":
        raise FileError(f"{option} -", "cannot go to standard output", "name a file")
    check_output(file, BESIDE_ENDINGS)
    if output != "-" and Path(file).resolve() == Path(output).resolve():
        raise FileError(f"{option} {file}", "is the file of the picture, too", "name another")


def write_normals(normal: np.ndarray[Any, Any], path: Path) -> None:
    """Write normals as they are (.npy), or as colours (.png): -1 to 1 becomes 0 to 255, nothing is black.

    Raises
    ------
    FileError
        When they cannot be written.
    """
    colours = np.where(normal.any(axis=-1, keepdims=True), 127.5 * (1 + normal) + 0.5, 0.0)
    write_beside(path, normal, colours.astype(np.uint8))


def write_disagreement(image: Any, path: Path) -> None:
    """Write the disagreement of offsets as it is (.npy), or over the picture (.png).

    Raises
    ------
    FileError
        When it cannot be written.
    """
    from ..rendering.disagreement import disagreement_picture

    found = image.disagreement
    write_beside(path, found, disagreement_picture(image.rgb, found))


def write_beside(path: Path, numbers: np.ndarray[Any, Any], picture: np.ndarray[Any, Any]) -> None:
    """Write numbers (.npy) or their picture (.png)."""
    with written(path) as temporary:
        if path.suffix.lower() == ".npy":
            np.save(temporary, numbers, allow_pickle=False)
            return
        from PIL import Image as Pillow

        Pillow.fromarray(picture).save(temporary, "png")


def write_stats(stats: dict[str, Any], target: str) -> None:
    """Write statistics as JSON to a file, or to standard error for ``-``."""
    text = json.dumps(stats, indent=2, default=plain) + "\n"
    if target == "-":
        sys.stderr.write(text)
        return
    write_text(Path(target), text)


def plain(value: Any) -> Any:
    """Mappings and numbers of NumPy as Python's, anything else as text."""
    if isinstance(value, Mapping):
        return dict(value)
    return value.tolist() if hasattr(value, "tolist") else str(value)
