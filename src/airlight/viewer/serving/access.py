"""Who may speak to the server: whoever holds its token, from its own pages, under its own names.

The token comes with the address that is opened. It moves to a cookie at once, by a redirect, so that it stays neither in the
address bar nor in what other sites are told. The cookie has no path of its own: browsers bind it to the folder of the page as
they see it, whatever prefix a proxy puts before it, and the server believes no header of a proxy.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

from ...errors import ValueRangeError

LOOPBACK = ("localhost", "127.0.0.1", "::1")
ANYWHERE = ("", "0.0.0.0", "::")
METHODS = ("GET", "HEAD")
TOLD_TO_BROWSERS = {
    "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self'; media-src blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
    "cache-control": "no-store",
}
ASK = "This page needs the address that airlight printed when it started.\n"


@dataclass(frozen=True)
class Access:
    """What a request must show.

    Parameters
    ----------
    token
        What the address holds that is printed.
    cookie
        Name of the cookie that takes its place.
    names
        Names under which the server may be called, so that no other name can be bent to its address.
    any_address
        Whether it may be called by any number, too: numbers cannot be bent.
    public
        Origin at which a proxy shows it, as ``https://hub.example.org``; empty where there is none.
    prefix
        Beginning of the path that a proxy may leave before ours, as ``/user/me/proxy/8000``.
    """

    token: str
    cookie: str
    names: frozenset[str] = frozenset(LOOPBACK)
    any_address: bool = False
    public: str = ""
    prefix: str = ""
    _once: set[str] = field(default_factory=set, repr=False)

    @classmethod
    def made(cls, port: int, host: str = "127.0.0.1", public_url: str = "") -> Access:
        """Return what a server at a port must be shown, with a new token.

        Raises
        ------
        ValueRangeError
            For a public address that is none.
        """
        try:
            parts = urlsplit(public_url)
        except ValueError:
            parts = urlsplit("")
        if public_url and (parts.scheme not in ("http", "https") or not parts.hostname or parts.query or parts.fragment):
            raise ValueRangeError("--public-url", f"is {public_url!r}", "e.g. https://hub.example.org/user/me/proxy/8000/")
        anywhere = host in ANYWHERE or (_is_number(host) and host not in LOOPBACK)
        names = {*LOOPBACK, host.lower(), *([socket.gethostname().lower()] if anywhere else [])} - {*ANYWHERE}
        names |= {parts.hostname} if parts.hostname else set()
        public = f"{parts.scheme}://{parts.netloc.lower()}" if public_url else ""
        token = secrets.token_urlsafe(32)
        return cls(token, f"airlight-{port}", frozenset(names), anywhere, public, parts.path.rstrip("/"))

    def once(self) -> str:
        """Return a token that opens one page: others may see with what a browser was started."""
        token = secrets.token_urlsafe(32)
        self._once.add(token)
        return token

    def admits(self, token: str) -> bool:
        """Whether an address with this token may be opened; one that is good for once is then used up."""
        if _same(token, self.token):
            return True
        used = [known for known in list(self._once) if _same(token, known)]
        self._once.difference_update(used)
        return bool(used)

    def is_known(self, headers: Mapping[str, list[str]]) -> bool:
        """Whether one of a request's cookies holds the token."""
        cookies = []
        for text in headers.get("cookie", []):
            for part in text.split(";"):
                try:
                    held = SimpleCookie(part).get(self.cookie)
                except CookieError:
                    continue
                cookies += [held.value] if held else []
        return any(_same(value, self.token) for value in cookies)

    def refusal(self, kind: str, method: str, headers: Mapping[str, list[str]]) -> tuple[int, str] | None:
        """Return why a request is refused whoever sends it, as status and words; None if it is not."""
        if kind == "http" and method not in METHODS:
            return 405, "Only GET and HEAD are answered.\n"
        hosts = headers.get("host", [])
        if len(hosts) != 1 or not self._is_own(hosts[0]):
            return 421, "airlight is not called by this name here (see --host and --public-url).\n"
        origins, sites = headers.get("origin", []), headers.get("sec-fetch-site", [])
        if kind == "websocket" and len(origins) != 1:
            return 403, "Only pages of this server open sockets.\n"
        if any(not self._is_origin(origin, hosts[0]) for origin in origins):
            return 403, "Pages of other servers may not ask this one.\n"
        if any(site in ("cross-site", "same-site") for site in sites) and headers.get("sec-fetch-mode") != ["navigate"]:
            return 403, "Pages of other servers may not ask this one.\n"
        return None

    def _is_own(self, host: str) -> bool:
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        return name in self.names or (self.any_address and _is_number(name))

    def _is_origin(self, origin: str, host: str) -> bool:
        return origin.lower() in {f"http://{host}".lower(), f"https://{host}".lower(), self.public} - {""}


def guarded(app: Any, access: Access) -> Any:
    """Return an ASGI application that answers only whom ``access`` lets in."""

    async def guard(scope: dict[str, Any], receive: Any, send: Any) -> None:
        kind, headers = scope["type"], _listed(scope["headers"])
        refused = access.refusal(kind, scope.get("method", "GET"), headers)
        if refused is None and kind == "http":
            path = scope["path"]
            if access.prefix and path == access.prefix:
                where = f"{access.prefix.rpartition('/')[2]}/?{scope['query_string'].decode('latin-1')}"
                return await _answer(send, 307, "", {"location": where})
            path = _behind(path, access.prefix)
            given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [])
            known = access.is_known(headers)
            if path == "/" and given and (known or access.admits(given[0])):
                safe = "; Secure" if access.public.startswith("https:") else ""
                cookie = f"{access.cookie}={access.token}; HttpOnly; SameSite=Strict{safe}"
                return await _answer(send, 303, "", {"location": "./", "set-cookie": cookie})
            if not known:
                # Browsers keep strict cookies back where another site led here; a page that asks again itself gets them.
                led = path == "/" and not given and headers.get("sec-fetch-site") == ["cross-site"]
                return await _answer(send, 403, ASK, {"refresh": "0; url=./"} if led else {})
            scope = {**scope, "path": path, "root_path": ""}
        elif refused is None:
            refused = None if access.is_known(headers) else (403, ASK)
            scope = {**scope, "path": _behind(scope["path"], access.prefix), "root_path": ""}
        if refused is not None and kind == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})
            return
        if refused is not None:
            await _answer(send, *refused, {"allow": ", ".join(METHODS)} if refused[0] == 405 else {})
            return
        await app(scope, receive, _with_headers(send) if kind == "http" else send)

    return guard


def _with_headers(send: Any) -> Any:
    told = [(name.encode(), value.encode()) for name, value in TOLD_TO_BROWSERS.items()]

    async def sending(message: dict[str, Any]) -> None:
        if message["type"] == "http.response.start":
            own = [pair for pair in message.get("headers", []) if pair[0].lower().decode() not in TOLD_TO_BROWSERS]
            message = {**message, "headers": [*own, *told]}
        await send(message)

    return sending


async def _answer(send: Any, status: int, text: str, headers: Mapping[str, str]) -> None:
    told = {"content-type": "text/plain; charset=utf-8", "content-length": str(len(text)), **headers}
    pairs = [(name.encode(), value.encode("latin-1")) for name, value in told.items()]
    await _with_headers(send)({"type": "http.response.start", "status": status, "headers": pairs})
    await send({"type": "http.response.body", "body": text.encode()})


def _listed(headers: Iterable[tuple[bytes, bytes]]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name, value in headers:
        found.setdefault(name.decode("latin-1").lower(), []).append(value.decode("latin-1"))
    return found


def _behind(path: str, prefix: str) -> str:
    return path[len(prefix) :] if prefix and path.startswith(f"{prefix}/") else path


def _same(one: str, other: str) -> bool:
    return hmac.compare_digest(one.encode(), other.encode())


def _is_number(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
