"""``airlight movie``: a turntable, the way between keyframes, or a volume over time, as a video or an animated picture."""

import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from ..errors import FileError
from ..movies.course import make_plan
from ..movies.making import write_movie
from ..movies.saving import keyframes_and_scene
from ..movies.targets import check_frames, checked_target
from ..movies.turning import Turntable, with_room_to_turn
from .build import is_scene, make_job
from .inputs import SCENE_INPUT
from .labels import LabelOptions, label_notes
from .options import DrawOptions, LookOptions, ReadOptions, ViewOptions
from .parse import parse_numbers, parse_size
from .progress import ProgressBar

MOVIE = Group("Movie", sort_key=0)


def movie(
    input: Annotated[str, Parameter(help=f"{SCENE_INPUT} A file with keyframes, too.")],
    /,
    *,
    output: Annotated[
        str,
        Parameter(
            name=["--output", "-o"],
            metavar="FILE",
            help="A .mp4 (H.264), .webm (VP9), .gif or .png (animated) file; a folder, or a name such as frame-%04d.png, for "
            "single frames.",
        ),
    ],
    turns: Annotated[
        float | None,
        Parameter(group=MOVIE, allow_leading_hyphen=True, help="How often it turns; 1 unless told, negative the other way."),
    ] = None,
    axis: Annotated[
        str,
        Parameter(
            group=MOVIE,
            metavar="AXIS",
            allow_leading_hyphen=True,
            help="What it turns about: scene (the world's z, superior in anatomy), view (up in the picture), or x,y,z.",
        ),
    ] = "scene",
    ease: Annotated[bool, Parameter(group=MOVIE, negative="", help="Begin and end the turn at rest.")] = False,
    lights_turn: Annotated[
        bool, Parameter(group=MOVIE, negative="", help="Lights turn with the object instead of staying with the eye.")
    ] = False,
    keyframes: Annotated[
        str | None,
        Parameter(
            group=MOVIE, metavar="FILE", help="A .toml or .json file with a list of keyframes, which tell how long it is."
        ),
    ] = None,
    over: Annotated[
        Literal["time"] | None,
        Parameter(group=MOVIE, help="Play all time steps of the volume, ten a second unless told; goes with --turns."),
    ] = None,
    seconds: Annotated[float | None, Parameter(group=MOVIE, help="How long it is; 6 unless told.")] = None,
    frames: Annotated[int | None, Parameter(group=MOVIE, help="How many frames it has, instead of --seconds.")] = None,
    fps: Annotated[float, Parameter(group=MOVIE, help="Frames a second; 30 unless told, at most 50 for .gif.")] = 30.0,
    quality: Annotated[int | None, Parameter(group=MOVIE, help="1 to 100, of .mp4 and .webm; 80 unless told.")] = None,
    look: LookOptions | None = None,
    view: ViewOptions | None = None,
    draw: DrawOptions | None = None,
    read: ReadOptions | None = None,
    labels: LabelOptions | None = None,
) -> None:
    """Make a movie of a volume or a scene.

    It is one turn in six seconds unless --turns, --keyframes or --over tell otherwise. All other options are those of render.
    For instance:

        airlight movie head.nii.gz -o head.mp4
        airlight movie ct.nrrd -o bone.webm --preset ct-bone --turns 2 --seconds 8 --size 1280x720
        airlight movie ct.nrrd -o bone.gif --frames 40 --fps 20 --size 320x240
        airlight movie scene.toml -o tour.mp4 --keyframes tour.toml
        airlight movie tour.toml -o tour.mp4
        airlight movie heart.nii.gz -o heart.mp4 --over time --seconds 10
        airlight movie head.nii.gz -o frames --frames 8 --background none

    mp4 and webm need the extra: pip install "airlight[movie]".
    """
    if output == "-":
        raise FileError("-o -", "cannot go to standard output", "name a file")
    target = checked_target(Path(output), fps, quality)
    view, draw = view or ViewOptions(), draw or DrawOptions()
    if view.size is not None:
        check_frames(target, parse_size(view.size), 1)
    of_turn = turns is not None or axis != "scene" or ease or lights_turn
    keys, folder, input = keyframes_and_scene(input, keyframes, alone=not of_turn and over is None)
    turntable = None
    if of_turn or (keys is None and over is None):
        easing = "smooth" if ease else "linear"
        turntable = Turntable(360 * (1.0 if turns is None else turns), _axis(axis), easing, not lights_turn)
    plan = make_plan(turntable, keys, over, seconds, frames)
    with ProgressBar() as progress:
        job = make_job(input, look or LookOptions(), view, draw, read or ReadOptions(), progress, labels)
        from ..rendering.renderer import shared

        scene = job.scene
        if turntable is not None and (isinstance(scene.camera, str) or not (view.camera or is_scene(input))):
            scene = with_room_to_turn(scene, turntable, job.size)
        made = write_movie(scene, target, plan, job.size, shared(draw.device), job.arguments, progress, folder)
    asked = () if labels is None else label_notes(scene.layers[0], labels)
    for note in (*made.notes, *asked):
        print(f"note: {note}", file=sys.stderr)


def _axis(text: str) -> str | tuple[float, float, float]:
    if "," not in text:
        return text
    x, y, z = parse_numbers(text, (3,), "--axis")
    return x, y, z
