"""``airlight.movie``: frames drawn one after the other by one renderer, and encoded while the next is drawn."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..api import as_scene
from ..errors import DataError
from ..files import written
from ..scene import Scene
from ..stage import Stage
from ..transfer.given import check_size
from .course import Plan, make_plan
from .keys import Keyframes
from .pictures import write_apng, write_frames, write_gif
from .saving import keyframes_and_scene
from .targets import Target, check_frames, checked_target
from .turning import Turntable, with_room_to_turn
from .video import write_video

if TYPE_CHECKING:
    from ..rendering.image import Image
    from ..rendering.renderer import Renderer

Progress = Callable[[str, int, int], None]
DRAWING = "drawing frames"
WRITERS = {"mp4": write_video, "webm": write_video, "gif": write_gif, "apng": write_apng}


@dataclass(frozen=True)
class Movie:
    """A movie that was written.

    Attributes
    ----------
    path
        Its file, the folder of its frames, or the name of single frames with their number as ``%04d``.
    size
        Width and height in pixels.
    fps
        Frames a second.
    frames
        How many frames it has.
    notes
        What was not reached in some of them: a tolerance, the whole size; and whether nothing was seen.
    """

    path: Path
    size: tuple[int, int]
    fps: float
    frames: int
    notes: tuple[str, ...] = ()

    @property
    def seconds(self) -> float:
        """How long it is."""
        return self.frames / self.fps


def movie(
    what: Any,
    path: str | os.PathLike[str],
    *,
    turns: float | Turntable | None = None,
    keyframes: Keyframes | Iterable[Any] | str | os.PathLike[str] | None = None,
    over: str | None = None,
    seconds: float | None = None,
    frames: int | None = None,
    fps: float = 30.0,
    size: tuple[int, int] = (512, 512),
    quality: int | None = None,
    driver: str | Stage = "march",
    step: float = 1.0,
    skip: str = "auto",
    tolerance: float | None = None,
    budget_ms: float | None = None,
    passes: Iterable[str | Stage] = (),
    device: str | int | None = None,
    progress: Progress | None = None,
) -> Movie:
    """Write a movie: a turntable, the way between keyframes, or the time steps of a volume.

    Without ``turns``, ``keyframes`` and ``over`` it is one turn in six seconds, or what a file with keyframes tells.

    Parameters
    ----------
    what
        As for ``airlight.render``; also a file with keyframes. Cameras that are chosen from the data, or by the name of a
        view, stand so far away that all of a turn is seen.
    path
        ``.mp4`` (H.264) and ``.webm`` (VP9), for which the extra ``movie`` is needed; ``.gif``; ``.png`` (animated, without
        loss); a folder, or a name such as ``"frame-%04d.png"``, for single frames. It appears whole or not at all.
    turns
        Number of turns, or a ``movies.Turntable``.
    keyframes
        ``movies.Keyframes``, or a list of pairs ``(time_s, changes)`` with values by their path in a scene file, or a file
        of them.
    over
        ``"time"`` plays all time steps of a volume, ten a second unless told; goes with ``turns``.
    seconds, frames
        How long it is, by one of the two. Keyframes tell it themselves.
    fps
        Frames a second, at most 50 for ``.gif``.
    size
        Width and height in pixels; even ones for ``.mp4`` and ``.webm``.
    quality
        1 to 100 for ``.mp4`` and ``.webm``, 80 unless told.
    driver, step, skip, tolerance, budget_ms, passes, device
        As for ``airlight.render``.
    progress
        Called with what is done, how many frames of it, and how many there are. What it raises ends the movie, and leaves no
        file.

    Returns
    -------
    Movie
        ``.path``, ``.size``, ``.fps``, ``.frames``, ``.seconds``, ``.notes``.

    Raises
    ------
    AirlightError
        Before anything is drawn for endings, sizes, keys, missing packages and transparent scenes that the file cannot take;
        and what ``airlight.render`` raises.

    Examples
    --------
    >>> import airlight as al
    >>> volume = al.samples.load("vortex", size=32)
    >>> al.movie(volume, "vortex.mp4", turns=1, seconds=4)                                    # doctest: +SKIP
    >>> keys = [(0, {}), (2, {"camera": "top"}), (3, {"layers[0].density": 0.2})]
    >>> al.movie(volume, "vortex.webm", keyframes=keys, size=(1280, 720))                     # doctest: +SKIP
    """
    from ..rendering.renderer import shared

    target = checked_target(Path(path), fps, quality)
    check_size(size)
    size_px = int(size[0]), int(size[1])
    check_frames(target, size_px, 1)
    drawing: dict[str, Any] = {"driver": driver, "step": step, "skip": skip, "tolerance": tolerance, "budget_ms": budget_ms}
    drawing["passes"] = tuple(passes)
    keys, folder, what = keyframes_and_scene(what, keyframes, alone=turns is None and over is None)
    plan = make_plan(turns, keys, over, seconds, frames)
    scene = as_scene(what, size_px, progress)
    if plan.turntable is not None and (isinstance(scene.camera, str) or not _is_scene(what)):
        scene = with_room_to_turn(scene, plan.turntable, size_px)
    return write_movie(scene, target, plan, size_px, shared(device), drawing, progress, folder)


def write_movie(
    scene: Scene,
    target: Target,
    plan: Plan,
    size_px: tuple[int, int],
    renderer: Renderer,
    drawing: dict[str, Any],
    progress: Progress | None = None,
    folder: str = ".",
) -> Movie:
    """Draw and write a movie of a scene; ``drawing`` are arguments of ``Renderer.render``, ``folder`` is that of the keys."""
    scenes = plan.scenes(scene, size_px, target.fps, folder)
    check_frames(target, size_px, len(scenes))
    if not target.takes_alpha and any(one.background is None for one in scenes):
        what = f"is none, and {target.path.suffix} is not transparent"
        raise DataError("scene.background", what, "give a colour (--background black), or write .webm or .png")
    notes: Counter[str] = Counter()
    images = drawn(renderer, scenes, size_px, drawing, progress)
    pictures = _pictures(images, notes, any(one.background is None for one in scenes))
    try:
        if target.kind == "frames":
            write_frames(pictures, target)
        else:
            with written(target.path) as temporary:
                WRITERS[target.kind](temporary, pictures, target)
    finally:
        pictures.close()
        images.close()
    told = tuple(f"{note} ({count} of {len(scenes)} frames)" for note, count in notes.items())
    return Movie(target.path, size_px, target.fps, len(scenes), told)


def drawn(
    renderer: Renderer,
    scenes: Sequence[Scene],
    size_px: tuple[int, int],
    drawing: dict[str, Any],
    progress: Progress | None = None,
) -> Generator[Image]:
    """Yield the image of each scene; the next is drawn while the caller looks at one. Neighbours that are one are drawn once.

    Closing it gives up what is not drawn yet.
    """
    views = object(), object()  # each is waited for before it is asked again

    def posted(number: int, before: Future[Image] | None) -> Future[Image]:
        if before is not None and scenes[number] is scenes[number - 1]:
            return before
        # What is uploaded once is told; after that frames are.
        options = drawing if number else drawing | {"progress": progress}
        return renderer.submit(scenes[number], size_px, **options, view=views[number % 2])

    try:
        if progress is not None:
            progress(DRAWING, 0, len(scenes))
        following = posted(0, None)
        for number in range(len(scenes)):
            current = following
            if number + 1 < len(scenes):
                following = posted(number + 1, current)
            yield current.result()
            if progress is not None:
                progress(DRAWING, number + 1, len(scenes))
    finally:
        for view in views:
            renderer.close_view(view)


def _pictures(images: Iterator[Image], notes: Counter[str], alpha: bool) -> Generator[Any]:
    """Pictures of images, all of them with alpha if some have it; what is to be told of them is counted."""
    import numpy as np

    for image in images:
        notes.update(_told(image))
        picture = image.picture()
        if alpha and picture.shape[2] == 3:
            picture = np.concatenate([picture, np.full_like(picture[..., :1], 255)], axis=-1)
        yield picture


def _told(image: Image) -> Iterator[str]:
    if image.stats.get("tolerance", {}).get("pixels_over"):
        yield "the tolerance was not reached everywhere"
    if image.stats.get("budget", {}).get("scale", 1.0) < 1:
        yield "drawn smaller and enlarged, to keep the budget"
    if not image.rgba.any():
        yield "nothing is visible"


def _is_scene(what: Any) -> bool:
    return isinstance(what, Scene) or (isinstance(what, (str, os.PathLike)) and os.fspath(what).endswith(".toml"))
