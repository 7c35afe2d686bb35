"""Running the server: a free port, a thread of its own, the address to open, and a quick end."""

from __future__ import annotations

import getpass
import os
import socket
import sys
import threading
import webbrowser
from collections.abc import Mapping
from typing import Any

from ...errors import ValueRangeError
from .access import ANYWHERE, Access, guarded
from .limits import Limits

BACKLOG = 64
END_S = 1.0


class Serving:
    """An application at a port of this machine; pages may come as soon as this is made, and are answered once it starts.

    Parameters
    ----------
    host, port
        Where it is bound; port 0 takes a free one.
    public_url
        Address under which a proxy shows it.

    Raises
    ------
    ValueRangeError
        When the port is taken, or the host is none of this machine.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 0, public_url: str = "") -> None:
        self.host = host
        self._socket = bound(host, port)
        self.port: int = self._socket.getsockname()[1]
        try:
            self.access = Access.made(self.port, host, public_url)
        except ValueRangeError:
            self._socket.close()
            raise
        self._public_url = public_url
        self._server: Any = None
        self._thread: threading.Thread | None = None

    def url(self, token: str | None = None) -> str:
        """Address to open, with the token that holds as long as the server runs, or another."""
        name = "127.0.0.1" if self.host in ANYWHERE else f"[{self.host}]" if ":" in self.host else self.host
        base = self._public_url.rstrip("/") or f"http://{name}:{self.port}"
        return f"{base}/?token={token or self.access.token}"

    def start(self, app: Any, limits: Limits | None = None) -> None:
        """Answer, on a thread of its own."""
        import uvicorn

        bounds = limits or Limits()
        config = uvicorn.Config(
            guarded(app, self.access),
            log_config=None,
            log_level="error",  # what strangers send is no news
            access_log=False,
            lifespan="off",
            server_header=False,
            proxy_headers=False,
            ws="websockets-sansio",
            ws_max_size=bounds.message_bytes,
            ws_per_message_deflate=False,
            ws_ping_timeout=bounds.stalled_s,  # an answer to a ping comes behind what is being read: a movie, through a tunnel
            limit_concurrency=8 * bounds.sockets,
            timeout_graceful_shutdown=1,
        )
        self._server = uvicorn.Server(config)
        run = self._server.run
        self._thread = threading.Thread(target=run, kwargs={"sockets": [self._socket]}, name="airlight-server", daemon=True)
        self._thread.start()

    def open_browser(self) -> None:
        """Show the page in the user's browser, by an address that opens it once; returns at once."""
        address = self.url(self.access.once())
        threading.Thread(target=webbrowser.open, args=(address,), name="airlight-browser", daemon=True).start()

    def stop(self) -> None:
        """End all connections and free the port. Idempotent."""
        if self._server is not None and self._thread is not None:
            self._server.should_exit = True
            self._thread.join(END_S)
            self._server.force_exit = True
            self._thread.join(END_S)
        self._socket.close()


def bound(host: str, port: int) -> socket.socket:
    """Return a socket that listens."""
    try:
        found = socket.getaddrinfo(host or None, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, kind, protocol, _, address = found[0]
    except (OSError, OverflowError) as error:
        raise ValueRangeError("--host", f"is {host!r}, no address of this machine", "e.g. 127.0.0.1") from error
    opened = socket.socket(family, kind, protocol)
    try:
        if os.name == "posix":
            opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        opened.bind(address)
        opened.listen(BACKLOG)
    except OSError as error:
        opened.close()
        where = f"--port {port}" if port else f"--host {host}"
        raise ValueRangeError(
            where, f"cannot be taken ({error.strerror})", "choose another, or port 0 for a free one"
        ) from error
    return opened


def is_remote(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether the user sits at another machine, from which this one was entered by ssh."""
    return bool(environment.get("SSH_CONNECTION"))


def has_display(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether a browser has somewhere to open; those of text would take the terminal away."""
    is_unix = sys.platform not in ("win32", "darwin")
    return not is_unix or any(environment.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))


def tunnel(port: int, environment: Mapping[str, str] = os.environ) -> str:
    """Return the command that leads from the user's own machine to a port of this one."""
    words = environment["SSH_CONNECTION"].split()
    address, ssh_port = (words[2], words[3]) if len(words) == 4 else (socket.gethostname(), "22")
    other = "" if ssh_port == "22" else f"-p {ssh_port} "
    return f"ssh -L {port}:127.0.0.1:{port} {other}{getpass.getuser()}@{address}"
