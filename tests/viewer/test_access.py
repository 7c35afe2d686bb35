"""Attacks on the server: without the token, by other names, from other pages, for other files, with wrong messages."""

from __future__ import annotations

import asyncio
import json
import re
import struct
import threading
import time
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient
from starlette.websockets import WebSocket, WebSocketDisconnect
from still import StillRenderer, wait_for

import airlight as al
from airlight.viewer import session as sessions
from airlight.viewer.document import Document
from airlight.viewer.front_end import SHEETS, WEB
from airlight.viewer.server import application, connected
from airlight.viewer.serving.access import Access, guarded
from airlight.viewer.serving.framing import packed, unpacked
from airlight.viewer.serving.limits import Limits, Outbox, Pace
from airlight.viewer.serving.lobby import Lobby
from airlight.viewer.session import Viewer
from airlight.viewer.telling import told

HELLO = {"type": "hello", "size_px": [8, 8], "ratio": 1}
BASE = "http://127.0.0.1:8000"
ORIGIN = {"origin": BASE, "host": "127.0.0.1:8000"}


@pytest.fixture
def viewer() -> Any:
    z, y, x = np.mgrid[-1:1:6j, -1:1:6j, -1:1:6j]
    volume = al.Volume(np.exp(-(x * x + y * y + z * z)).astype(np.float32), name="Jane Doe")
    made = Viewer(Document(al.Scene(volume)), "head.nrrd", StillRenderer())  # type: ignore[arg-type]
    yield made
    made.close()


@pytest.fixture
def access() -> Access:
    return Access.made(8000)


@pytest.fixture
def client(viewer: Viewer, access: Access) -> TestClient:
    return TestClient(
        guarded(application(viewer), access), base_url=BASE, follow_redirects=False, raise_server_exceptions=False
    )


def enter(client: TestClient, access: Access) -> TestClient:
    assert client.get(f"/?token={access.token}").status_code == 303
    return client


def next_of(socket: Any, kind: str) -> dict[str, Any]:
    while True:
        message, _ = unpacked(socket.receive_bytes())
        if message["type"] == kind:
            return message


# -- the token


def test_the_token_moves_to_a_cookie_at_once(client: TestClient, access: Access) -> None:
    moved = client.get(f"/?token={access.token}")
    assert moved.status_code == 303
    assert moved.headers["location"] == "./"
    cookie = moved.headers["set-cookie"]
    assert cookie.startswith("airlight-8000=")
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    assert not re.search("path|domain", cookie.lower()), "browsers bind it to the folder that they see"
    assert client.get("/").status_code == 200
    assert access.token not in client.get("/").text


@pytest.mark.parametrize(
    "path", ["/", "/web/page.js", "/?token=", "/?token=x", "/web/page.js?token={token}", "/socket", "/nothing"]
)
def test_without_the_token_there_is_nothing(client: TestClient, access: Access, path: str) -> None:
    answer = client.get(path.format(token=access.token))
    assert answer.status_code == 403
    assert "set-cookie" not in answer.headers
    assert "Traceback" not in answer.text


@pytest.mark.parametrize("cookie", ["airlight-8000=", "airlight-8000=x", "airlight-8001={token}", 'airlight-8000="', "{token}"])
def test_other_cookies_are_none(client: TestClient, access: Access, cookie: str) -> None:
    assert client.get("/", headers={"cookie": cookie.format(token=access.token)}).status_code == 403


def test_a_cookie_among_many_is_found(client: TestClient, access: Access) -> None:
    cookie = f'a=b; bad[name]="; airlight-8000=thrown-by-another-port; airlight-8000={access.token}'
    assert client.get("/", headers={"cookie": cookie}).status_code == 200


def test_what_a_browser_is_started_with_opens_once(client: TestClient, access: Access) -> None:
    once = access.once()
    assert client.get(f"/?token={once}").status_code == 303
    client.cookies.clear()
    assert client.get(f"/?token={once}").status_code == 403


def test_a_page_that_another_site_led_to_asks_again_itself(client: TestClient) -> None:
    led = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}
    assert client.get("/", headers=led).headers["refresh"] == "0; url=./"
    assert "refresh" not in client.get("/", headers=led | {"sec-fetch-site": "same-origin"}).headers
    assert "refresh" not in client.get("/web/page.js", headers=led).headers


# -- names, pages and methods


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example:8000", "", "[", "10.0.0.7:8000"]
)
def test_names_that_are_bent_to_this_machine(client: TestClient, access: Access, host: str) -> None:
    enter(client, access)
    assert client.get("/", headers={"host": host}).status_code == 421
    with (
        pytest.raises(WebSocketDisconnect),
        client.websocket_connect("/socket", headers={"host": host, "origin": f"http://{host}"}),
    ):
        pass


@pytest.mark.parametrize("host", ["localhost:9000", "127.0.0.1:8000", "[::1]:8000", "LOCALHOST"])
def test_own_names_through_any_tunnel(client: TestClient, access: Access, host: str) -> None:
    assert client.get(f"/?token={access.token}", headers={"host": host}).status_code == 303


def test_two_hosts_are_none(access: Access) -> None:
    assert access.refusal("http", "GET", {"host": ["localhost", "evil.example"]}) is not None
    assert access.refusal("http", "GET", {}) is not None


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "https://evil.example"},
        {"origin": "null"},
        {"origin": "http://127.0.0.1:9999"},
        {"sec-fetch-site": "cross-site", "sec-fetch-mode": "no-cors"},
        {"sec-fetch-site": "same-site", "sec-fetch-mode": "cors"},
    ],
)
def test_other_pages_may_not_ask(client: TestClient, access: Access, headers: dict[str, str]) -> None:
    enter(client, access)
    assert client.get("/", headers=headers).status_code == 403
    if "origin" in headers:
        with pytest.raises(WebSocketDisconnect), client.websocket_connect("/socket", headers=ORIGIN | headers):
            pass


def test_sockets_need_origin_and_cookie(client: TestClient, access: Access) -> None:
    with pytest.raises(WebSocketDisconnect), client.websocket_connect("/socket", headers=ORIGIN):
        pass
    with pytest.raises(WebSocketDisconnect), client.websocket_connect(f"/socket?token={access.token}", headers=ORIGIN):
        pass
    known = ORIGIN | {"cookie": f"{access.cookie}={access.token}"}
    with (
        pytest.raises(WebSocketDisconnect),
        client.websocket_connect("/socket", headers={"host": known["host"], "cookie": known["cookie"]}),
    ):
        pass
    with client.websocket_connect("/socket", headers=known) as socket:
        socket.send_bytes(packed(HELLO))
        assert next_of(socket, "welcome")["session"]


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT"])
def test_only_pages_are_read(client: TestClient, access: Access, method: str) -> None:
    answer = enter(client, access).request(method, "/")
    assert answer.status_code == 405
    assert answer.headers["allow"] == "GET, HEAD"


def test_other_machines_only_when_asked() -> None:
    assert Access.made(1).refusal("http", "GET", {"host": ["192.168.0.7:1"]}) is not None
    anywhere = Access.made(1, "0.0.0.0")
    assert anywhere.refusal("http", "GET", {"host": ["192.168.0.7:1"]}) is None
    assert anywhere.refusal("http", "GET", {"host": ["evil.example:1"]}) is not None, "numbers cannot be bent, names can"


# -- behind a proxy


@pytest.mark.parametrize("leaves", ["", "/user/me/proxy/8000"])
def test_behind_a_prefix(viewer: Viewer, leaves: str) -> None:
    """Proxies that take their prefix away, and those that leave it; whatever headers they send is not believed."""
    access = Access.made(8000, public_url="https://hub.example.org/user/me/proxy/8000/")
    client = TestClient(guarded(application(viewer), access), base_url="https://hub.example.org", follow_redirects=False)
    lies = {"x-forwarded-prefix": "/evil", "x-forwarded-host": "evil.example", "forwarded": "host=evil.example"}
    moved = client.get(f"{leaves}/?token={access.token}", headers=lies)
    assert moved.status_code == 303
    assert moved.headers["location"] == "./"
    assert "Secure" in moved.headers["set-cookie"]
    known = {"cookie": moved.headers["set-cookie"].partition(";")[0]}
    assert client.get(f"{leaves}/web/page.js", headers=known | lies).status_code == 200
    inner = {"host": "127.0.0.1:8000", "origin": "https://hub.example.org"}
    with client.websocket_connect(f"{leaves}/socket", headers=known | inner) as socket:
        socket.send_bytes(packed(HELLO))
        next_of(socket, "welcome")
    with (
        pytest.raises(WebSocketDisconnect),
        client.websocket_connect("/socket", headers=known | inner | {"origin": "https://evil.example"}),
    ):
        pass
    if leaves:
        assert client.get(f"{leaves}?token=x").headers["location"] == "8000/?token=x"


def test_the_page_names_nothing_from_elsewhere(client: TestClient, access: Access) -> None:
    text = enter(client, access).get("/").text
    for address in re.findall(r'(?:src|href)="([^"]*)"', text):
        assert address.startswith(("web/", "data:,"))
    assert "<script>" not in text
    assert "style=" not in text


def test_what_browsers_are_told(client: TestClient, access: Access) -> None:
    for answer in (client.get("/"), enter(client, access).get("/"), client.get("/web/page.js"), client.get("/nothing")):
        policy = answer.headers["content-security-policy"]
        assert policy.startswith("default-src 'none'")
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["cross-origin-opener-policy"] == "same-origin"
        assert "server" not in answer.headers


# -- files


@pytest.mark.parametrize(
    "path",
    [
        "../session.py",
        "%2e%2e/session.py",
        "..%2fsession.py",
        "/etc/passwd",
        "%2fetc%2fpasswd",
        ".",
        "",
        "panels",
        "app.js",
        "page.js%00",
    ],
)
def test_only_listed_files(client: TestClient, access: Access, path: str) -> None:
    assert enter(client, access).get(f"/web/{path}").status_code == 404


def test_the_page_is_three_texts(client: TestClient, access: Access) -> None:
    """A request for each module would take longer than the page may."""
    page = enter(client, access).get("/").text
    told = {"web/page.js": "text/javascript; charset=utf-8", "web/page.css": "text/css; charset=utf-8"}
    assert set(re.findall(r'(?:src|href)="(web/[^"]*)"', page)) == told.keys()
    for name, kind in told.items():
        answer = client.get(f"/{name}")
        assert answer.status_code == 200
        assert answer.headers["content-type"] == kind
        assert not re.search(r"^import|@import|import\(", answer.text, re.MULTILINE)


def test_every_style_sheet_is_in_the_page() -> None:
    assert sorted(SHEETS) == sorted(path.relative_to(WEB).as_posix() for path in WEB.rglob("*.css"))


@pytest.mark.parametrize(
    "text",
    [
        "/home/me/a.nrrd",
        "/home/jane doe/x y/a.nrrd",
        "no space left on device: '/home/jane doe/a.nrrd'",
        "clips[0]: /home/jane doe/a.nrrd",
        "is read from /home/me/a.nrrd",
        "C:\\Users\\Jane Doe\\a.nrrd",
    ],
)
def test_errors_name_no_folders(text: str) -> None:
    for part in told(al.FileError(text, text, text)).values():
        assert "a.nrrd" in part
        assert not re.search(r"home|jane|doe|users", part.lower())
    assert told(al.FileError("step", "is 1 / 2 / 3, see https://x.org/a/b"))["what"] == "is 1 / 2 / 3, see https://x.org/a/b"


def test_errors_stay_here(access: Access) -> None:
    async def broken(scope: Any, receive: Any, send: Any) -> None:
        raise OSError("/home/me/secret.nrrd")

    from starlette.applications import Starlette
    from starlette.routing import Mount

    client = TestClient(guarded(Starlette(routes=[Mount("/", broken)]), access), base_url=BASE, raise_server_exceptions=False)
    answer = client.get("/x", headers={"cookie": f"airlight-8000={access.token}"})
    assert answer.status_code == 500
    assert answer.text == "Internal Server Error"


# -- messages


@pytest.mark.parametrize(
    "frame",
    [
        b"",
        b"\0",
        b"\1\0\0\0\xff\xff\xff\xff{}",
        struct.pack("<I", 1 << 31),
        struct.pack("<2I", 1, 3) + b"{}",
        struct.pack("<2I", 1, 2) + b"[]",
        struct.pack("<2I", 1, 9) + b'{"a":NaN}',
        struct.pack("<2I", 1, 4) + b"\xff\xfe{}",
        struct.pack("<2I", 1, 100_000) + b"[" * 100_000,
        struct.pack("<2I", 1, 205) + b'{"a":' + b"[" * 100 + b"]" * 99 + b"]}" + b"    ",
    ],
)
def test_frames_that_are_none(frame: bytes) -> None:
    with pytest.raises(al.ValueRangeError):
        unpacked(frame)


def test_a_wrong_frame_ends_its_own_socket_only(viewer: Viewer) -> None:
    client = TestClient(application(viewer))
    with client.websocket_connect("/socket") as good, client.websocket_connect("/socket") as bad:
        bad.send_bytes(b"nonsense")
        with pytest.raises(WebSocketDisconnect) as ended:
            next_of(bad, "never")
        assert ended.value.code == 1007
        good.send_bytes(packed(HELLO))
        next_of(good, "welcome")


@pytest.mark.parametrize(
    "message",
    [
        {"type": "nothing"},
        {"type": ["hello"]},
        {},
        {"type": "hello"},
        {"type": "hello", "size_px": "x"},
        {"type": "size", "size_px": [1e400 if False else "9" * 5000, 1]},
        {"type": "edit", "ops": {"a": 1}},
        {"type": "edit", "ops": [{"op": "set", "path": ["scene", "__class__"], "value": 1}]},
        {"type": "gesture", "kind": "orbit", "dx": "x"},
        {"type": "ack", "frame": []},
        {"type": "ask", "id": 1, "what": "../session"},
        {"type": "ask", "id": 1, "what": "files.begin", "arguments": {"session": 1}},
    ],
)
def test_wrong_messages_change_nothing(viewer: Viewer, message: dict[str, Any]) -> None:
    session, heard = viewer.session(), []
    before = session.document
    session.receive(message, (), lambda told, _: heard.append(told))
    wait_for(lambda: heard)
    assert heard[0]["type"] == "error" or "error" in heard[0]
    assert "Traceback" not in json.dumps(heard)
    assert session.document == before


def test_sizes_are_bounded(viewer: Viewer) -> None:
    session = viewer.session()
    session.receive({"type": "size", "size_px": [60_000, -5]})
    assert session.size_px == (session.stream.MOST_PX, 1)


def test_long_messages_end_the_socket(viewer: Viewer) -> None:
    client = TestClient(application(viewer, Limits(message_bytes=1000)), base_url=BASE)
    with client.websocket_connect("/socket") as socket:
        socket.send_bytes(packed({"type": "hello", "x": "y" * 1000}))
        with pytest.raises(WebSocketDisconnect) as ended:
            next_of(socket, "welcome")
        assert ended.value.code == 1009


def test_whoever_sends_too_fast_waits() -> None:
    pace = Pace(100.0, 10)
    start = time.monotonic()
    assert [pace.pause_s(start) for _ in range(10)] == [0.0] * 10
    assert pace.pause_s(start) == pytest.approx(0.01, abs=1e-6)
    assert pace.pause_s(start + 1) == 0.0


def test_whoever_does_not_read_is_cut_off() -> None:
    async def fill() -> None:
        outbox = Outbox(100)
        outbox.put(b"x")
        outbox.put(b"y" * 500)  # one may be as long as it likes, whatever is before it
        assert [await outbox.take(), await outbox.take()] == [b"x", b"y" * 500]
        for _ in range(3):
            outbox.put(b"z" * 40)
        await asyncio.sleep(0)
        assert not outbox.overflowed.is_set()
        outbox.put(b"z")
        await asyncio.wait_for(outbox.overflowed.wait(), 5)

    asyncio.run(fill())


@pytest.mark.parametrize("limits", [Limits(waiting_bytes=10), Limits(stalled_s=0.01)])
def test_sockets_end_that_take_nothing(viewer: Viewer, limits: Limits) -> None:
    """The connection's own buffer is full, so that sending waits for ever."""

    class Stuck:
        query_params: dict[str, str] = {}  # noqa: RUF012

        def __init__(self) -> None:
            self.messages = [packed(HELLO)] * 9

        async def accept(self) -> None: ...

        async def receive(self) -> dict[str, Any]:
            data = self.messages.pop() if self.messages else await self.send_bytes(b"")
            return {"type": "websocket.receive", "bytes": data}

        async def send_bytes(self, data: bytes) -> Any:
            await asyncio.Event().wait()

    lobby = Lobby(viewer)
    asyncio.run(asyncio.wait_for(connected(Stuck(), lobby, limits), 5))
    assert lobby.sockets == 0
    assert not any(session.has_clients for session in viewer.sessions.values())


def test_sockets_are_counted(viewer: Viewer) -> None:
    client = TestClient(application(viewer, Limits(sockets=1)), base_url=BASE)
    with client.websocket_connect("/socket"):
        with pytest.raises(WebSocketDisconnect) as ended, client.websocket_connect("/socket"):
            pass
        assert ended.value.code == 1013
    with client.websocket_connect("/socket") as socket:
        socket.send_bytes(packed(HELLO))
        next_of(socket, "welcome")


@pytest.mark.parametrize("kind", [al.FileError, al.ValueRangeError])
def test_pages_that_wait_are_told_why_nothing_comes(kind: type[al.AirlightError]) -> None:
    lobby = Lobby()
    lobby.viewer.set_exception(kind("/home/me/a.nrrd", "is none"))
    with TestClient(application(lobby)).websocket_connect("/socket") as socket:
        assert next_of(socket, "error")["where"] == "a.nrrd"
        with pytest.raises(WebSocketDisconnect) as ended:
            socket.receive_bytes()
        assert ended.value.code == 1013


def test_who_goes_while_being_sent_to_has_gone(viewer: Viewer) -> None:
    """Sending fails first, and the code with which the page was closed is still that of the socket."""
    failed = asyncio.Event()
    events: list[dict[str, Any]] = [{"type": "websocket.connect"}, {"type": "websocket.receive", "bytes": packed(HELLO)}]

    async def receive() -> dict[str, Any]:
        if events:
            return events.pop(0)
        await failed.wait()
        return {"type": "websocket.disconnect", "code": 1001}

    async def send(event: dict[str, Any]) -> None:
        if event["type"] == "websocket.send":
            failed.set()
            raise OSError

    lobby = Lobby(viewer)
    socket = WebSocket({"type": "websocket", "query_string": b"", "headers": []}, receive, send)  # type: ignore[arg-type]
    asyncio.run(asyncio.wait_for(connected(socket, lobby, Limits()), 5))
    assert lobby.empty_s() > 0


def test_questions_are_counted(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    session, heard, held = viewer.session(), [], threading.Event()
    monkeypatch.setattr(sessions, "is_slow", lambda what: not held.wait(5))
    for number in range(sessions.MOST_QUESTIONS + 1):
        session.receive({"type": "ask", "id": number, "what": "files"}, (), lambda told, _: heard.append(told))
    assert [(told["id"], told["error"]["where"]) for told in heard] == [(sessions.MOST_QUESTIONS, "ask")]
    held.set()


def test_sessions_that_have_ended_answer_and_let_go(viewer: Viewer) -> None:
    client, heard = TestClient(application(viewer), base_url=BASE), []
    with client.websocket_connect("/socket") as socket:
        socket.send_bytes(packed(HELLO))
        session = viewer.sessions[next_of(socket, "welcome")["session"]]
        viewer.end(session)
        session.receive({"type": "ask", "id": 3, "what": "files"}, (), lambda told, _: heard.append(told))
        assert (heard[0]["id"], heard[0]["error"]["where"]) == (3, "view")
        socket.send_bytes(packed(HELLO))
        with pytest.raises(WebSocketDisconnect) as ended:
            next_of(socket, "welcome")
        assert ended.value.code == 1012  # the page comes back, and finds another


# -- sessions


def test_a_wrong_key_is_a_new_session(viewer: Viewer) -> None:
    one = viewer.session()
    assert viewer.session(one.key) is one
    for key in ("", None, one.key[:-1], one.key + "x", "0", "../" + one.key):
        assert viewer.session(key) is not one
    assert len(one.key) >= 20


def test_no_message_reaches_another_session(viewer: Viewer) -> None:
    one, other, heard = viewer.session(), viewer.session(), []
    one.listen(lambda message, _: heard.append(message))
    before = one.document
    for message in (HELLO | {"session": one.key}, {"type": "edit", "ops": [], "session": one.key}, {"type": "undo"}):
        other.receive(message)
    viewer.end(other)
    assert one.document is before
    assert not heard
    assert one.key in viewer.sessions


def test_answers_go_to_who_asked(viewer: Viewer) -> None:
    session, mine, others = viewer.session(), [], []
    session.listen(lambda message, _: others.append(message))
    session.receive({"type": "ask", "id": 7, "what": "files"}, (), lambda message, _: mine.append(message))
    wait_for(lambda: mine)
    assert mine[0]["id"] == 7
    assert "value" in mine[0]
    assert not [message for message in others if message["type"] == "answer"]


def test_sessions_are_bounded(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sessions, "MOST_SESSIONS", 2)
    one, two = viewer.session(), viewer.session()
    one.listen(lambda message, _: None)
    three = viewer.session()
    assert set(viewer.sessions) == {one.key, three.key}, "the one that nobody looked at has made room"
    assert viewer.session(two.key).key != two.key
    viewer.sessions[list(viewer.sessions)[-1]].listen(lambda message, _: None)
    with pytest.raises(al.LimitError):
        viewer.session()


def test_pages_wait_for_the_viewer(viewer: Viewer) -> None:
    lobby = Lobby()
    lobby.progress("reading head.nrrd", 1, 4)
    client = TestClient(application(lobby), base_url=BASE)
    with client.websocket_connect("/socket") as socket:
        socket.send_bytes(packed(HELLO))
        assert next_of(socket, "progress") == {"type": "progress", "what": "reading head.nrrd", "done": 1, "total": 4}
        lobby.viewer.set_result(viewer)
        next_of(socket, "welcome")
    lobby = Lobby()
    lobby.viewer.set_exception(al.FileError("/home/me/head.nrrd", "is damaged"))
    with TestClient(application(lobby), base_url=BASE).websocket_connect("/socket") as socket:
        assert next_of(socket, "error")["where"] == "head.nrrd"


def test_a_closed_page_is_gone_and_a_cut_one_is_not() -> None:
    lobby = Lobby()
    assert lobby.empty_s() == 0, "nobody has come yet"
    lobby.entered()
    lobby.left(1001)
    time.sleep(0.002)
    assert lobby.empty_s() > 0
    lobby.entered()
    lobby.left(1006)
    time.sleep(0.002)
    assert lobby.empty_s() == 0, "it will be back"


# -- what headers hold


def test_clients_learn_neither_names_nor_paths(tmp_path: Any) -> None:
    folder = tmp_path / "Jane_Doe"
    folder.mkdir()
    z, y, x = np.mgrid[-1:1:6j, -1:1:6j, -1:1:6j]
    al.save(al.Volume(np.exp(-(x * x + y * y + z * z)).astype(np.float32), name="DOE^JANE", units="mm"), folder / "scan.nrrd")
    volume = al.open(folder / "scan.nrrd")
    viewer = Viewer(Document(al.first_picture(volume)), "scan.nrrd", StillRenderer())  # type: ignore[arg-type]
    session, heard = viewer.session(), []
    session.listen(lambda message, _: heard.append(message))
    session.receive(HELLO)
    for number, what in enumerate(("files", "save.scene", "code")):
        session.receive({"type": "ask", "id": number, "what": what, "arguments": {}})
    wait_for(lambda: sum(message["type"] == "answer" for message in heard) == 3)
    viewer.close()
    text = json.dumps(heard)
    assert "scan.nrrd" in text
    assert "mm" in text
    for secret in ("Jane", "JANE", "DOE", str(tmp_path), "Doe"):
        assert secret not in text
