"""JavaScript modules as one text, for hosts that take no folder of files: notebooks, and pages that are one file."""

from __future__ import annotations

import posixpath
import re
from graphlib import TopologicalSorter
from pathlib import Path

_IMPORT = re.compile(r'^import \{ ([^}]*) \} from "(\.{1,2}/[\w./-]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?:async )?(?:function\*?|const|let) (\w+)", re.MULTILINE)


def bundled(folder: Path, entry: str) -> str:
    """One script of a module and all that it imports, each in a scope of its own, imported ones first.

    Modules import names by lines of ``import { a, b as c } from "./x.js";``, ``default`` among them, and export functions and
    constants where they stand. The entry's ``export default`` stays one, at the end.

    Parameters
    ----------
    folder
        Where the modules lie.
    entry
        Path of the first one below it, with forward slashes.
    """
    texts, needs = {entry: _source(folder, entry)}, dict[str, list[str]]()
    while rest := texts.keys() - needs.keys():
        for name in rest:
            needs[name] = [_beside(name, found[2]) for found in _IMPORT.finditer(texts[name])]
            texts |= {other: _source(folder, other) for other in needs[name] if other not in texts}
    parts = []
    for name in TopologicalSorter(needs).static_order():
        scope = f"const {_scope(name)} = (() => {{\n{_body(name, texts[name])}}})();\n"
        parts.append(scope)
    end = f"export default {_scope(entry)}.default_;\n" if "\nexport default " in texts[entry] else ""
    return "".join(parts) + end


def _body(name: str, text: str) -> str:
    """A module's text as the body of a function that returns what it exports."""

    def taken(found: re.Match[str]) -> str:
        names = found[1].replace("default as ", "default_ as ").replace(" as ", ": ")
        return f"const {{ {names} }} = {_scope(_beside(name, found[2]))};\n"

    body = _IMPORT.sub(taken, text)
    names = _EXPORT.findall(body)
    body, count = re.subn(r"^export default ", "const default_ = ", body, flags=re.MULTILINE)
    names += ["default_"] * count
    return re.sub(r"^export ", "", body, flags=re.MULTILINE) + f"return {{ {', '.join(names)} }};\n"


def _source(folder: Path, name: str) -> str:
    return folder.joinpath(*name.split("/")).read_text(encoding="utf-8")


def _beside(name: str, given: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(name), given))


def _scope(name: str) -> str:
    return "of_" + re.sub(r"\W", "_", name.removesuffix(".js"))
