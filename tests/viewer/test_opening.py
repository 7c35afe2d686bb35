"""Opening in a viewer: of the folder alone, uploads within their limits; and the server, from start to end."""

from __future__ import annotations

import gc
import signal
import socket
import threading
import time
import urllib.error
import urllib.request
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from still import StillRenderer, wait_for
from websockets.sync.client import connect

import airlight as al
from airlight.app.cli import main
from airlight.app.view import _ended_by_signals
from airlight.viewer import session as sessions
from airlight.viewer import showing as shows
from airlight.viewer.asked import save
from airlight.viewer.document import Document
from airlight.viewer.opening import is_nothing, nothing, opened
from airlight.viewer.serving.framing import packed, unpacked
from airlight.viewer.serving.running import tunnel
from airlight.viewer.session import Session, Viewer
from airlight.viewer.shelf import Shelf


def quiet(*_: Any) -> None: ...


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("scans")
    z, y, x = np.mgrid[-1:1:6j, -1:1:6j, -1:1:6j]
    ball = al.Volume(np.exp(-(x * x + y * y + z * z)).astype(np.float32), units="mm")
    for name in ("open/a.nrrd", "open/sub/b.nrrd", "secret/c.nrrd"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        al.save(ball, root / name)
    (root / "open/notes.txt").write_text("nothing")
    (root / "open/.hidden.nrrd").write_bytes(b"")
    (root / "open/out.nrrd").symlink_to(root / "secret/c.nrrd")
    (root / "open/outside").symlink_to(root / "secret")
    (root / "open/bad.nrrd").write_bytes(b"NRRD0004\ntype: float\ndimension: 3\nsizes: 9 9 9\nencoding: raw\n\nshort")
    return root / "open"


def test_only_volumes_of_the_folder_are_listed(folder: Path) -> None:
    shelf = Shelf(folder)
    assert [entry.name for entry in shelf.entries()] == ["a.nrrd", "bad.nrrd", "sub/b.nrrd"]
    assert [entry.id for entry in shelf.entries()] == ["f0", "f1", "f2"]
    assert Shelf().entries() == []


def test_links_that_change_later_lead_nowhere(folder: Path, tmp_path: Path) -> None:
    own = tmp_path / "own"
    own.mkdir()
    (own / "x.nrrd").write_bytes((folder / "a.nrrd").read_bytes())
    shelf = Shelf(own)
    (entry,) = shelf.entries()
    (own / "x.nrrd").unlink()
    (own / "x.nrrd").symlink_to(folder / "a.nrrd")
    with pytest.raises(al.FileError, match="leads out"):
        shelf.open_entry(entry.id, quiet)


def test_links_within_a_volume_lead_nowhere(folder: Path, tmp_path: Path) -> None:
    volume = tmp_path / "own/a.zarr"
    (volume / "c").mkdir(parents=True)
    (volume / "zarr.json").write_text("{}")
    (volume / "c/0").symlink_to(folder / "a.nrrd")
    shelf = Shelf(volume.parent)
    (entry,) = shelf.entries()
    with pytest.raises(al.FileError, match=r"a\.zarr holds links"):
        shelf.open_entry(entry.id, quiet)


@pytest.mark.parametrize("key", ["f9", "a.nrrd", "../secret/c.nrrd", "/etc/passwd", ""])
def test_only_ids_open(folder: Path, key: str) -> None:
    shelf = Shelf(folder)
    shelf.entries()
    with pytest.raises(al.FileError, match="not in the folder"):
        shelf.open_entry(key, quiet)


def test_errors_name_no_folder(folder: Path) -> None:
    shelf = Shelf(folder)
    bad = next(entry for entry in shelf.entries() if entry.name == "bad.nrrd")
    with pytest.raises(al.AirlightError) as told:
        shelf.open_entry(bad.id, quiet)
    assert "bad.nrrd" in str(told.value)
    assert str(folder.parent) not in str(told.value)


def test_uploads_are_bounded_and_private() -> None:
    shelf = Shelf(most_upload_bytes=100)
    for files in ([], [("a.nrrd", 101)], [("a.nrrd", 60), ("b.raw", 60)], [("x", 1)] * 5000):
        with pytest.raises(al.LimitError):
            shelf.begin("me", files)
    for files in ([("a.nrrd", 0)], [("a.raw", 1), ("a.raw", 1)]):
        with pytest.raises(al.ValueRangeError):
            shelf.begin("me", files)
    key = shelf.begin("me", [("../../etc/evil name\x00.nrrd", 10)])
    path = shelf._uploads[key].paths[0]
    assert path.name == "evil_name_.nrrd"
    assert path.parent.stat().st_mode & 0o077 == 0
    with pytest.raises(al.FileError):
        shelf.add("other", key, 0, 0, b"x")
    for file, at, data in ((0, 1, b"x"), (1, 0, b"x"), (-1, 0, b"x"), (0, 0, b"x" * 11)):
        with pytest.raises(al.ValueRangeError):
            shelf.add("me", key, file, at, data)
    assert shelf.add("me", key, 0, 0, b"12345") == (5, 10)
    with pytest.raises(al.FileError, match="whole"):
        shelf.open_upload("me", key, quiet)
    assert not path.parent.exists(), "nothing is left of it"
    first = shelf.begin("me", [("a.nrrd", 10)])
    second = shelf.begin("me", [("b.nrrd", 10)])
    assert list(shelf._uploads) == [second] != [first]
    held = shelf._uploads[second].paths[0].parent
    shelf.close()
    assert not held.exists()


def asked(session: Session, what: str, buffers: tuple[bytes, ...] = (), **arguments: Any) -> dict[str, Any]:
    heard: list[dict[str, Any]] = []
    message = {"type": "ask", "id": 1, "what": what, "arguments": arguments}
    session.receive(message, buffers, lambda told, _: heard.append(told))
    deadline = time.monotonic() + 60
    while not heard and time.monotonic() < deadline:
        time.sleep(0.01)
    return heard[0].get("value") or heard[0]


def test_a_file_that_a_client_brings(folder: Path) -> None:
    viewer = Viewer(nothing(), "", StillRenderer())  # type: ignore[arg-type]
    session = viewer.session()
    assert asked(session, "files")["nothing"]
    data = (folder / "a.nrrd").read_bytes()
    upload = asked(session, "files.begin", names=["head.nrrd"], sizes=[len(data)])["upload"]
    assert asked(session, "files.piece", (data[:99],), upload=upload, file=0, at=0) == {"done": 99, "total": len(data)}
    asked(session, "files.piece", (data[99:],), upload=upload, file=0, at=99)
    other = viewer.session()
    assert "error" in asked(other, "files.open", upload=upload)
    assert asked(session, "files.open", upload=upload) == {"name": "head.nrrd"}
    assert session.name == "head.nrrd"
    assert not is_nothing(session.document)
    assert session.document.scene.layers[0].volume.source.path == "head.nrrd"  # type: ignore[union-attr]
    assert not viewer.shelf._uploads
    assert is_nothing(other.document)
    assert asked(session, "files.open", sample="vortex", way="layer") == {"name": "vortex"}
    assert len(session.document.scene.layers) == 2
    for wrong in ({}, {"sample": "x"}, {"id": "f0"}, {"sample": "vortex", "id": "f0"}, {"path": "/etc/passwd"}):
        assert "error" in asked(session, "files.open", **wrong)
    viewer.close()


def test_opening_is_a_step_of_undo() -> None:
    volume = al.samples.load("vortex", size=8)
    empty = nothing()
    assert is_nothing(empty)
    first = opened(empty, volume, "layer", (64, 64))
    assert [layer.volume for layer in first.scene.layers] == [volume]
    assert len(opened(first, volume, "layer", (64, 64)).scene.layers) == 2
    with pytest.raises(al.ValueRangeError):
        opened(first, volume, "beside", (64, 64))


# -- the server itself


def fetched(url: str) -> tuple[int, str]:
    try:
        with urllib.request.build_opener(urllib.request.HTTPCookieProcessor()).open(url, timeout=10) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def test_from_the_first_page_to_a_free_port(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("airlight.rendering.renderer.shared", lambda device=None: StillRenderer())
    z, y, x = np.mgrid[-1:1:6j, -1:1:6j, -1:1:6j]
    document = Document(al.first_picture(al.Volume(np.exp(-(x * x + y * y + z * z)).astype(np.float32))))
    with shows.Showing() as showing:
        port = showing.serving.port
        status, page = fetched(showing.url)
        assert status == 200
        assert 'src="web/page.js"' in page
        assert fetched(f"http://127.0.0.1:{port}/")[0] == 403
        headers = {"Cookie": f"airlight-{port}={showing.serving.access.token}"}
        origin: Any = f"http://127.0.0.1:{port}"
        address = f"ws://127.0.0.1:{port}/socket"
        with connect(address, origin=origin, additional_headers=headers) as client:
            client.send(packed({"type": "hello", "size_px": [8, 8], "ratio": 1}))
            showing.show(document, "ball.nrrd")
            while unpacked(client.recv(timeout=10))[0]["type"] != "state":  # type: ignore[arg-type]
                pass
        wait_for(lambda: showing.lobby.empty_s() > 0)
        with pytest.raises(Exception, match="403"):
            connect(address, origin=origin)
        with connect(address, origin=origin, additional_headers=headers, max_size=None) as client:
            client.send(b"x" * (3 << 20))
            with pytest.raises(Exception, match="1009"):
                list(client)
        begun = time.monotonic()
    assert time.monotonic() - begun < 1.5
    again = socket.create_server(("127.0.0.1", port))
    again.close()


def test_the_command_refuses_before_anything_is_opened(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, folder: Path
) -> None:
    monkeypatch.setattr("airlight.app.cli._warm_up", quiet)
    monkeypatch.setattr(shows, "Showing", None)
    for words, what in (
        (["nothing.nrrd"], "does not exist"),
        (["vortx"], "the sample vortex"),
        ([str(folder / "a.nrrd"), "--budget", "5"], "--budget"),
        (["--window"], "--window"),
        ([str(folder / "a.nrrd"), "--max-upload", "x"], "x"),
    ):
        assert main(["view", *words]) == 2
        assert what in capsys.readouterr().err


def test_the_command_names_a_port_that_is_taken(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("airlight.app.cli._warm_up", quiet)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["view", "vortex", "--no-browser", "--port", str(port)]) == 2
    told = capsys.readouterr()
    assert f"--port {port}" in told.err
    assert "token" not in told.out
    assert main(["view", "vortex", "--no-browser", "--public-url", "ftp://x"]) == 2


def test_scripts_wait_and_errors_come_before_a_page(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(al.FileError, match="does not exist"):
        al.view("nothing.nrrd")
    assert "token" not in capsys.readouterr().out
    monkeypatch.setattr("airlight.rendering.renderer.shared", lambda device=None: StillRenderer())
    monkeypatch.setattr(shows, "CLOSED_S", -1.0)  # as if all pages had been closed
    assert al.view(al.samples.load("vortex", size=6), browser=False, block=True) is None
    with al.view(browser=False, block=False) as showing:
        assert is_nothing(showing.viewer.first)
        assert showing.url in capsys.readouterr().out


def test_the_way_from_another_machine() -> None:
    told = tunnel(8123, {"SSH_CONNECTION": "10.0.0.2 50000 192.0.2.7 2222"})
    assert told.startswith("ssh -L 8123:127.0.0.1:8123 -p 2222 ")
    assert told.endswith("@192.0.2.7")
    assert not shows.is_remote({})
    assert shows.has_display({"DISPLAY": ":0"})


def test_folders_of_volumes_and_volumes_that_are_folders(folder: Path, tmp_path: Path) -> None:
    assert shows.is_folder_of_volumes(folder)
    assert not shows.is_folder_of_volumes(folder / "a.nrrd")
    (tmp_path / "zarr.json").write_text("{}")
    assert not shows.is_folder_of_volumes(tmp_path)


def test_sessions_forget_what_they_were_brought(monkeypatch: pytest.MonkeyPatch) -> None:
    viewer = Viewer(nothing(), "", StillRenderer())  # type: ignore[arg-type]
    session = viewer.session()
    asked(session, "files.begin", names=["a.nrrd"], sizes=[9])
    assert viewer.shelf._uploads
    viewer.end(session)
    assert not viewer.shelf._uploads
    assert sessions.MOST_SESSIONS <= 64
    viewer.close()


def test_volumes_that_nothing_brings_back_are_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("airlight.viewer.history.MOST_BYTES", 0)
    viewer = Viewer(nothing(), "", StillRenderer())  # type: ignore[arg-type]
    session, seen = viewer.session(), []
    session.receive({"type": "hello", "size_px": [8, 8]})
    for _ in range(3):
        volume = al.Volume(np.mgrid[:6, :6, :6][0].astype(np.float32))
        seen.append(weakref.ref(volume))
        session.change(opened(session.document, volume, "replace", (8, 8)))
        del volume
    wait_for(lambda: gc.collect() and [ref() is None for ref in seen] == [True, True, False])
    assert len(session.held.volumes) == 1
    viewer.close()


def test_what_is_saved_ends_with_its_session() -> None:
    viewer = Viewer(nothing(), "", StillRenderer())  # type: ignore[arg-type]
    session = viewer.session()
    with save.working(session) as check:
        check("drawing", 0, 1)
        viewer.close()
        with pytest.raises(save.CancelledSavingError):
            check("drawing", 0, 1)


def test_sessions_end_with_their_widget() -> None:
    pytest.importorskip("anywidget")
    from airlight.viewer.notebook import widget

    viewer = Viewer(nothing(), "", StillRenderer())  # type: ignore[arg-type]
    here, there = widget(viewer), widget(viewer)
    here.close()
    assert list(viewer.sessions.values()) == [there.session]
    there.comm.handle_close({})  # the front-end has deleted it
    assert not viewer.sessions
    assert here.session.has_ended


def test_nothing_is_served_on_when_something_breaks(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[shows.Showing] = []
    whole = shows.Showing.__init__
    monkeypatch.setattr(shows.Showing, "__init__", lambda self, *given: (made.append(self), whole(self, *given))[1])
    monkeypatch.setattr(shows.Showing, "show", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        al.view(browser=False, block=False)
    assert made[0].serving._socket.fileno() == -1


def test_a_start_that_hangs_does_not_hold_up_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """As Ctrl-C may leave it, within an import."""
    let_go = threading.Event()
    monkeypatch.setattr(shows, "START_S", 0.01)
    monkeypatch.setattr(shows.Showing, "_start", _held_up(let_go, shows.Showing._start))
    showing = shows.Showing()
    showing.close()
    assert showing._starting.is_alive()
    let_go.set()
    showing._starting.join(5)
    assert showing.serving._thread is None, "what begins after the end is not served"


def _held_up(until: threading.Event, work: Callable[..., None]) -> Callable[..., None]:
    def later(*given: Any) -> None:
        until.wait(10)
        work(*given)

    return later


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="there are no terminals that hang up")
def test_a_terminal_that_hangs_up_ends_it_in_order() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)  # which nohup, where it runs the tests, has ignored
    try:
        with pytest.raises(KeyboardInterrupt), _ended_by_signals():
            signal.raise_signal(signal.SIGHUP)
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        with _ended_by_signals():
            signal.raise_signal(signal.SIGHUP)  # as under nohup
    finally:
        signal.signal(signal.SIGHUP, before)
