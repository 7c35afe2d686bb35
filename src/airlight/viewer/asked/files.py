"""What may be opened, and opening it: files of the folder, samples, and what clients bring piece by piece."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ... import samples
from ...errors import ValueRangeError
from ...first_picture import automatic_transfer
from ...samples.analytic import COMPUTED
from ...samples.registry import FETCHED
from ...volume import Volume
from ..asking import answers
from ..opening import is_nothing, opened
from ..session import Session
from ..shelf import name_of


@answers("files")
def files(session: Session) -> dict[str, Any]:
    """What may be opened: volumes of the folder, samples, and how much may be brought."""
    shelf = session.viewer.shelf
    return {
        "folder": None if shelf.folder is None else shelf.folder.name,
        "files": [{"id": entry.id, "name": entry.name, "bytes": entry.bytes} for entry in shelf.entries()],
        "samples": [{"name": name, "title": _title(name)} for name in samples.names()],
        "most_bytes": shelf.most_upload_bytes,
        "nothing": is_nothing(session.document),
    }


@answers("files.begin")
def begin(session: Session, names: list[Any], sizes: list[Any]) -> dict[str, Any]:
    """Begin to bring files; the answer's key is that of further pieces."""
    if not isinstance(names, list) or not isinstance(sizes, list) or len(names) != len(sizes):
        raise ValueRangeError("files", "must be as many names as sizes")
    told = [(str(name)[:400], _whole(size, "size")) for name, size in zip(names, sizes, strict=True)]
    return {"upload": session.viewer.shelf.begin(session.key, told)}


@answers("files.piece")
def piece(session: Session, upload: str, file: int, at: int, buffers: list[bytes]) -> dict[str, Any]:
    """Take a piece of a file; the answer tells how much is there."""
    data = b"".join(buffers)
    done, total = session.viewer.shelf.add(session.key, str(upload), _whole(file, "file"), _whole(at, "at"), data)
    return {"done": done, "total": total}


@answers("files.forget")
def forget(session: Session) -> dict[str, Any]:
    """Give up what was brought."""
    session.viewer.shelf.forget(session.key)
    return {}


@answers("files.open", slow=True)
def open_file(
    session: Session, upload: str | None = None, id: str | None = None, sample: str | None = None, way: str = "replace"
) -> dict[str, Any]:
    """Open what was brought, a volume of the folder or a sample, in the place of what is shown or as a layer."""
    if [upload, id, sample].count(None) != 2:
        raise ValueRangeError("files.open", "needs one of upload, id and sample")
    session.tell_progress("opening", 0, 0)
    volume = _volume(session, upload, id, sample)
    session.tell_progress("choosing a first picture", 0, 0)
    automatic_transfer(volume)  # is kept: what is edited meanwhile is not lost, since the rest takes no time
    document = opened(session.document, volume, str(way), session.size_px)
    session.change(document)
    if len(document.scene.layers) == 1:
        session.chose()
        session.keep(lambda habits: replace(habits, home=document.camera))
    session.tell_progress("opening", 1, 1)
    return {"name": name_of(volume)}


def _volume(session: Session, upload: str | None, key: str | None, sample: str | None) -> Volume:
    shelf = session.viewer.shelf
    if upload is not None:
        return shelf.open_upload(session.key, str(upload), session.tell_progress)
    if key is not None:
        return shelf.open_entry(str(key), session.tell_progress)
    return samples.load(str(sample), progress=session.tell_progress)


def _title(name: str) -> str:
    return COMPUTED[name].title if name in COMPUTED else FETCHED[name].title


def _whole(value: Any, where: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 1 << 50:
        raise ValueRangeError(where, f"is {value!r:.40}, must be a whole number of at least 0")
    return value
