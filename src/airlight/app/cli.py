"""The command ``airlight``: where it starts, and how its errors end it. Each command is a module, imported when used."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cyclopts import App

COMMANDS = {
    "render": "Render a volume or a scene to an image.",
    "view": "Look at a volume or a scene in the browser or a window.",
    "movie": "Make a movie: a turntable, keyframes, or a volume over time.",
    "export": "Write a page that draws a volume in any browser with WebGPU.",
    "info": "Tell what a file holds: size, geometry, units, range, histogram.",
    "devices": "List the adapters that can render, and which is chosen.",
    "demo": "Fetch a sample volume and render it.",
    "explain": "Print the program that draws a volume or a scene.",
    "bench": "Measure time and error of a fixed set of scenes.",
    "stages": "List slots, stages and their parameters.",
    "histogram": "Draw how many samples have which value and gradient.",
    "presets": "List transfer functions by name, and colour maps.",
}
HELP = """\
Volume rendering through WebGPU: right, fast and simple to read.

For instance:

    airlight demo
    airlight view head.nii.gz
    airlight render head.nii.gz -o head.png
    airlight render ct.nrrd -o bone.png --preset ct-bone --camera iso --size 1024x1024
    airlight info ct.nrrd

--debug, anywhere, shows where in the code an error came from."""

USAGE_ERROR, INTERRUPTED, BROKEN_PIPE = 2, 130, 141
M_ARENA_MAX = -8  # of glibc's malloc.h


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns 0, 2 for errors, 130 when interrupted, 141 when nobody reads the output."""
    words = list(sys.argv[1:] if argv is None else argv)
    debug = "--debug" in words
    words = [word for word in words if word != "--debug"]
    try:
        code = _run(words, debug)
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # What is still buffered would fail again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE


def _run(words: list[str], debug: bool) -> int:
    from ..errors import AirlightError

    try:
        if words[:1] == ["view"]:
            _keep_few_heaps()
        if words[:1] in (["render"], ["movie"], ["view"]) and not {"--help", "-h"} & set(words):
            _warm_up(_given(words, "--device"))
        plugins = _given(words, "--plugin")
        if plugins:
            from .plugin import load_plugins

            # Before the command is imported: its help lists the stages that are known then.
            load_plugins(plugins)
        return _dispatch(with_stats_target(words), debug)
    except BrokenPipeError:
        raise
    except (AirlightError, OSError, MemoryError) as error:
        if debug:
            raise
        print(f"error: {error}" if str(error) else "error: out of memory", file=sys.stderr)
        return USAGE_ERROR


def _dispatch(words: list[str], debug: bool) -> int:
    from cyclopts import CycloptsError

    try:
        result = make_app(words[0] if words else "")(
            words, exit_on_error=False, print_error=False, result_action="return_value"
        )
    except CycloptsError as error:
        if debug:
            raise
        print(f"error: {error}", file=sys.stderr)
        command = f" {words[0]}" if words and words[0] in COMMANDS else ""
        print(f"see: airlight{command} --help", file=sys.stderr)
        return USAGE_ERROR
    return result if isinstance(result, int) else 0


def make_app(chosen: str = "") -> App:
    """Return the command line; no command's module is imported yet. The chosen command's help is its docstring."""
    from cyclopts import App, Parameter

    quiet = Parameter(show_default=False)
    app = App(
        name="airlight",
        help=HELP,
        help_format="plaintext",
        version=_version,
        default_parameter=quiet,
        suppress_keyboard_interrupt=False,
    )
    for name, summary in COMMANDS.items():
        app.command(f"airlight.app.{name}:{name}", name=name, **({} if name == chosen else {"help": summary}))
    return app


def with_stats_target(words: list[str]) -> list[str]:
    """Give ``--stats`` its value: without a file ending in ``.json`` it means standard error."""
    done = []
    for word, following in zip(words, [*words[1:], ""], strict=True):
        done.append("--stats=-" if word == "--stats" and not (following.endswith(".json") or following == "-") else word)
    return done


def _given(words: list[str], option: str) -> list[str]:
    """Values of an option, found before the command line is parsed."""
    named = [following for word, following in itertools.pairwise(words) if word == option]
    return named + [word.removeprefix(f"{option}=") for word in words if word.startswith(f"{option}=")]


def _keep_few_heaps() -> None:
    """Have the C library (glibc) keep a heap for each processor instead of eight, unless its environment tells how many.

    What compilers of shaders and pictures have taken and given back lies in the heap of their thread, where no other finds it:
    a process that lives for long would grow until each has as much as it ever needed.
    """
    if sys.platform.startswith("linux") and "MALLOC_ARENA_MAX" not in os.environ:
        import ctypes

        tell = getattr(ctypes.CDLL(None), "mallopt", None)
        if tell is not None:
            tell(M_ARENA_MAX, os.cpu_count() or 1)


def _warm_up(wanted: list[str]) -> None:
    """Start the adapter in the background while the command line and the file are read."""
    from .. import api

    api.warm_up(wanted[-1] if wanted else None)


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return f"airlight {version('airlight')}"
    except PackageNotFoundError:
        return "airlight, not installed"


if __name__ == "__main__":
    sys.exit(main())
