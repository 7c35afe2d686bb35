"""What clients may open: files of one folder, samples, and what they bring themselves.

They name all of it by ids and keys, never by paths. Whatever is opened here is read in a process of its own, and errors tell
names of files alone.
"""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from .. import io
from ..errors import AirlightError, FileError, LimitError, ValueRangeError
from ..io.formats import EXTENSIONS, extension_of
from ..volume import Source, Volume

Progress = Callable[[str, int, int], None]

MOST_UPLOAD_BYTES = 4 << 30
MOST_MEMORY_BYTES = 8 << 30
MOST_FILES = 4096  # of one upload: the slices of a series
MOST_LISTED, MOST_DEPTH = 1000, 4
HEADERS = (".mhd", ".nhdr", ".hdr")  # files that name the one that holds the samples


@dataclass(frozen=True)
class Entry:
    """A volume of the folder: what clients call it, its name below the folder, and its size, 0 for a folder."""

    id: str
    name: str
    bytes: int


@dataclass
class Upload:
    """Files that a client is bringing, and how much of each is there."""

    owner: str
    names: list[str]
    sizes: list[int]
    folder: tempfile.TemporaryDirectory[str] = field(default_factory=lambda: tempfile.TemporaryDirectory(prefix="airlight-"))
    there: list[int] = field(default_factory=list)

    @property
    def paths(self) -> list[Path]:
        """Where the files lie; their names are made of letters that no system minds."""
        return [Path(self.folder.name) / name for name in self.names]


class Shelf:
    """What clients of a viewer may open.

    Parameters
    ----------
    folder
        Folder whose volumes they may; None for none.
    most_upload_bytes
        Most that they may bring at a time.
    most_bytes
        Most that a file may unpack to.
    """

    def __init__(
        self, folder: Path | None = None, most_upload_bytes: int = MOST_UPLOAD_BYTES, most_bytes: int = MOST_MEMORY_BYTES
    ) -> None:
        self.folder = None if folder is None else folder.resolve()
        self.most_upload_bytes, self.most_bytes = most_upload_bytes, most_bytes
        self._ids: dict[str, str] = {}  # id of each name below the folder
        self._uploads: dict[str, Upload] = {}
        self._lock = threading.Lock()

    # -- the folder

    def entries(self) -> list[Entry]:
        """Volumes of the folder and of those in it, by name."""
        if self.folder is None:
            return []
        with self._lock:
            found = sorted(_volumes_in(self.folder, self.folder, 0))[:MOST_LISTED]
            return [Entry(self._ids.setdefault(name, f"f{len(self._ids)}"), name, size) for name, size in found]

    def open_entry(self, key: str, progress: Progress) -> Volume:
        """Open a volume of the folder by its id.

        Raises
        ------
        FileError
            For an id that was not given, and where a link leads out of the folder.
        """
        name = next((name for name, known in self._ids.items() if known == key), None)
        if self.folder is None or name is None:
            raise FileError(f"file {key!r:.40}", "is not in the folder", "choose one that is listed")
        path = (self.folder / name).resolve()
        if not path.is_relative_to(self.folder):
            raise FileError(name, "leads out of the folder that was opened", "choose another")
        if any(not link.resolve().is_relative_to(self.folder) for link in _links_in(path)):
            raise FileError(name, "holds links that lead out of the folder that was opened", "choose another")
        return self._opened(path, name, progress)

    # -- what clients bring

    def begin(self, owner: str, files: Sequence[tuple[str, int]]) -> str:
        """Make room for files, given by name and size; returns the key of the upload. An owner has one at a time.

        Raises
        ------
        LimitError
            When they are too many or too large.
        """
        if not 1 <= len(files) <= MOST_FILES:
            raise LimitError("files", f"are {len(files)}, may be 1 to {MOST_FILES}", "choose less, or a folder of DICOM files")
        total = sum(size for _, size in files)
        if min(size for _, size in files) < 1:
            raise ValueRangeError("files", "hold an empty one", "choose others")
        if total > self.most_upload_bytes:
            what = f"take {total:,} bytes, and {self.most_upload_bytes:,} may be brought"
            raise LimitError("files", what, "start airlight view with the file, or with --max-upload")
        if total > shutil.disk_usage(tempfile.gettempdir()).free // 2:
            raise LimitError(
                "files", f"take {total:,} bytes, for which the disk has no room", "start airlight view with the file"
            )
        self.forget(owner)
        names = [_safe(name, n, len(files)) for n, (name, _) in enumerate(files)]
        if len(set(names)) < len(names):
            raise ValueRangeError("files", "hold two of one name", "choose those of one volume")
        key = secrets.token_urlsafe(16)
        with self._lock:
            self._uploads[key] = Upload(owner, names, [size for _, size in files], there=[0] * len(files))
        return key

    def add(self, owner: str, key: str, file: int, at: int, data: bytes) -> tuple[int, int]:
        """Write a piece of a file behind what is there; returns bytes of all files that are there, and that there will be.

        Raises
        ------
        FileError
            For a key that is not the owner's.
        ValueRangeError
            For pieces out of order or beyond the size that was told.
        """
        upload = self._upload(owner, key)
        with self._lock:
            if not 0 <= file < len(upload.sizes) or at != upload.there[file] or at + len(data) > upload.sizes[file]:
                raise ValueRangeError("upload", "has a piece that does not follow on the last", "begin again")
            with upload.paths[file].open("ab") as held:
                held.write(data)
            upload.there[file] += len(data)
            return sum(upload.there), sum(upload.sizes)

    def open_upload(self, owner: str, key: str, progress: Progress) -> Volume:
        """Open what a client has brought; the files are deleted then.

        Raises
        ------
        FileError
            When something is missing, or cannot be read.
        """
        upload = self._upload(owner, key)
        try:
            if upload.there != upload.sizes:
                raise FileError(upload.names[0], "has not come as a whole", "choose it again")
            header = next((path for path in upload.paths if path.suffix.lower() in HEADERS), None)
            path = header or (upload.paths[0] if len(upload.paths) == 1 else Path(upload.folder.name))
            name = path.name if path in upload.paths else "series"
            volume = self._opened(path, name, progress)
            # The file is gone; its name is what scenes and scripts call it.
            volume.source = replace(volume.source or Source(""), path=name)
            return volume
        finally:
            self.forget(owner)

    def forget(self, owner: str) -> None:
        """Delete what a client has brought. Idempotent."""
        with self._lock:
            for key in [key for key, upload in self._uploads.items() if upload.owner == owner]:
                self._uploads.pop(key).folder.cleanup()

    def close(self) -> None:
        """Delete all that was brought. Idempotent."""
        for upload in list(self._uploads.values()):
            self.forget(upload.owner)

    def _upload(self, owner: str, key: str) -> Upload:
        upload = self._uploads.get(key)
        if upload is None or upload.owner != owner:
            raise FileError("upload", "is not known", "choose the file again")
        return upload

    def _opened(self, path: Path, name: str, progress: Progress) -> Volume:
        with nameless({str(path): name, f"{path.parent}{os.sep}": "", str(path.parent): "it"}):
            return io.open(path, untrusted=True, max_memory=self.most_bytes, progress=progress)


@contextlib.contextmanager
def nameless(shown: dict[str, str]) -> Iterator[None]:
    """Errors that leave the block say what is shown instead of paths; longer ones first."""
    try:
        yield
    except AirlightError as error:
        parts = [error.where, error.what, error.remedy]
        for path, name in shown.items():
            parts = [part.replace(path, name) for part in parts]
        raise type(error)(*parts) from None


def name_of(volume: Volume) -> str:
    """What clients see a volume called: the name of its file, or of a sample; never what its header calls it."""
    from ..samples import names

    if volume.name in names():
        return volume.name
    return "" if volume.source is None else Path(volume.source.path).name


def _safe(name: str, number: int, count: int) -> str:
    """Name of a file that is the end of the one given, without what could lead elsewhere; one of several has its number."""
    plain = re.sub(r"[^\w.+-]+", "_", name.replace("\\", "/").rpartition("/")[2])[-100:].lstrip(".-") or "file"
    if count == 1 or extension_of(Path(plain)) in (*HEADERS, ".raw", ".zraw", ".img", ".gz", ".bz2"):
        return plain  # a header names its file
    return f"{number:05}-{plain}"


def _links_in(path: Path) -> Iterator[Path]:
    """Links in a folder that is a volume, at any depth; none in a file."""
    with contextlib.suppress(NotADirectoryError), os.scandir(path) as found:
        for entry in found:
            if entry.is_symlink():
                yield Path(entry.path)
            elif entry.is_dir():
                yield from _links_in(Path(entry.path))


def _volumes_in(folder: Path, root: Path, depth: int) -> Iterator[tuple[str, int]]:
    """Names below a root, and sizes, of files that are told to be volumes, and of folders that are ones."""
    with contextlib.suppress(OSError), os.scandir(folder) as found:
        for entry in found:
            path = Path(entry.path)
            if entry.name.startswith(".") or not (entry.is_dir() or extension_of(path) in EXTENSIONS):
                continue
            name = path.relative_to(root).as_posix()
            if not path.resolve().is_relative_to(root):
                continue
            if entry.is_dir():
                if extension_of(path) == ".zarr" or any(path.glob("*.dcm")):
                    yield name, 0
                elif depth < MOST_DEPTH and not entry.is_symlink():
                    yield from _volumes_in(path, root, depth + 1)
            elif entry.is_file():
                yield name, entry.stat().st_size
