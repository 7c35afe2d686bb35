"""Plugins: Python files or modules that register stages. Only the command line names them, never a scene file."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterable
from pathlib import Path

from ..errors import AirlightError, FileError, StageError


def load_plugins(names: Iterable[str]) -> None:
    """Import each file or module once; what it registers is known by name from then on."""
    for name in names:
        try:
            if name.endswith(".py") or "/" in name or "\\" in name:
                _load_file(Path(name))
            else:
                importlib.import_module(name)
        except AirlightError:
            raise
        except ModuleNotFoundError as error:
            if error.name != name.partition(".")[0]:
                raise StageError(f"--plugin {name}", f"needs the module {error.name!r}, which is not installed") from error
            raise FileError(f"--plugin {name}", "is no module that Python finds", "give the path of a .py file") from error
        except Exception as error:
            raise StageError(f"--plugin {name}", f"failed with {type(error).__name__}: {error}") from error


def _load_file(path: Path) -> None:
    path = path.resolve()
    module_name = f"airlight_plugin_{path.stem}"
    known = sys.modules.get(module_name)
    if known is not None and getattr(known, "__file__", None) == str(path):
        return
    if not path.is_file():
        raise FileError(f"--plugin {path}", "is not there")
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None:
        raise FileError(f"--plugin {path}", "is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module  # dataclasses look their module up
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[module_name]
        raise
