"""``airlight view``: a volume or a scene in the browser, or in a window of its own."""

import contextlib
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..errors import AirlightError, ValueRangeError
from ..stage import make_stage
from .inputs import SCENE_INPUT, check_named
from .labels import LabelOptions
from .options import SERVE, DrawOptions, LookOptions, ReadOptions, ServeOptions, ViewOptions
from .parse import parse_bytes


def view(
    input: Annotated[str | None, Parameter(help=f"{SCENE_INPUT} A folder of volumes offers them; without it, samples.")] = None,
    /,
    *,
    look: LookOptions | None = None,
    camera: ViewOptions | None = None,
    draw: DrawOptions | None = None,
    read: ReadOptions | None = None,
    labels: LabelOptions | None = None,
    serve: ServeOptions | None = None,
    window: Annotated[bool, Parameter(group=SERVE, negative="", help="Open a window instead of a page.")] = False,
) -> None:
    """Look at a volume or a scene, turn it, and change how it is drawn.

    The page's address is printed and opened in the browser; Ctrl-C ends it.

    For instance:

        airlight view head.nii.gz
        airlight view ct.nrrd --preset ct-bone --shade blinn_phong:shininess=40
        airlight view scene.toml
        airlight view scans/
        airlight view ct.nrrd --no-browser --port 8000
        airlight view ct.nrrd --window
    """
    from ..viewer.opening import nothing
    from ..viewer.shelf import Shelf
    from ..viewer.showing import Showing, check_served, is_folder_of_volumes

    serve, draw, read = serve or ServeOptions(), draw or DrawOptions(), read or ReadOptions()
    if draw.budget is not None:
        raise ValueRangeError("--budget", "is for airlight render", "leave it out: while it moves the picture is drawn in time")
    if input is not None:
        check_named(input)
    shelf_of: dict[str, Any] = {"most_upload_bytes": parse_bytes(serve.max_upload), "most_bytes": parse_bytes(read.max_memory)}
    look, camera = look or LookOptions(), camera or ViewOptions()
    if window:
        _in_window(input, look, camera, draw, read, labels, Shelf(**shelf_of))
        return
    check_served()
    with _ended_by_signals(), Showing(serve.host, serve.port, serve.public_url, draw.device) as showing:
        try:
            print(f"{showing.words()}\nCtrl-C ends it", flush=True)
            if serve.browser:
                showing.open_browser()
            if input is None or is_folder_of_volumes(Path(input)):
                showing.show(nothing(), "", Shelf(None if input is None else Path(input).expanduser(), **shelf_of))
            else:
                from ..viewer.bookmarks import of_keyframes

                document = _document(input, look, camera, draw, read, labels, showing.lobby.progress)
                showing.show(document, Path(input).name, Shelf(**shelf_of), of_keyframes(input, document))
            showing.wait()
        except KeyboardInterrupt:
            print(file=sys.stderr)
        except AirlightError as error:
            showing.fail(error)
            raise


def _document(
    input: str,
    look: LookOptions,
    camera: ViewOptions,
    draw: DrawOptions,
    read: ReadOptions,
    labels: LabelOptions | None,
    progress: Any,
) -> Any:
    """What is drawn of a volume or a scene file, as ``airlight render`` draws it."""
    from ..first_picture import resolve
    from ..viewer.document import TOLERANCE, Document
    from .build import is_scene, make_job

    job = make_job(input, look, camera, draw, read, progress, labels)
    drawing = dict(job.arguments)
    # Whoever names a step does not mean another.
    drawing.setdefault("tolerance", None if "step" in drawing else TOLERANCE)
    drawing["driver"] = make_stage("driver", drawing.get("driver", "march"))
    is_named = camera.camera is not None or is_scene(input)
    chosen_for = None if is_named and not isinstance(job.scene.camera, str) else job.size[0] / job.size[1]
    return Document(resolve(job.scene, job.size), chosen_for=chosen_for, **drawing)


def _in_window(
    input: str | None,
    look: LookOptions,
    camera: ViewOptions,
    draw: DrawOptions,
    read: ReadOptions,
    labels: LabelOptions | None,
    shelf: Any,
) -> None:
    from ..rendering.renderer import shared
    from ..viewer.bookmarks import of_keyframes
    from ..viewer.session import Viewer
    from ..viewer.showing import show_window
    from .progress import ProgressBar

    if input is None:
        raise ValueRangeError("--window", "needs something to look at", "name a file, or leave --window out")
    with ProgressBar() as progress:
        document = _document(input, look, camera, draw, read, labels, progress)
    viewer = Viewer(document, Path(input).name, shared(draw.device))
    viewer.shelf, viewer.bookmarks = shelf, of_keyframes(input, document)
    show_window(viewer)


@contextlib.contextmanager
def _ended_by_signals() -> Iterator[None]:
    """Let what ends processes, or their terminal, do what Ctrl-C does, so that nothing is left behind."""

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    kinds = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {kind: found for kind in kinds if (found := signal.getsignal(kind)) is not signal.SIG_IGN}  # as nohup has it
    for kind in before:
        signal.signal(kind, interrupted)
    try:
        yield
    finally:
        for kind, found in before.items():
            signal.signal(kind, found)
