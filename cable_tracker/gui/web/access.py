"""Access to the server: from this machine alone, or with the token."""

from __future__ import annotations

import ipaddress
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any, TypeAlias
from urllib.parse import parse_qs, urlsplit

Scope: TypeAlias = MutableMapping[str, Any]
Message: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[Message]]
Send: TypeAlias = Callable[[Message], Awaitable[None]]
Application: TypeAlias = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = "cable_tracker_token_"
"""Start of the cookie's name. The port follows: browsers send a host's cookies to all its ports."""

REFUSED_BY_CLOSING = 1008
"""WebSocket's code for a violation of policy (RFC 6455, 7.4.1)."""


def is_loopback(host: str) -> bool:
    """Tell whether an address to listen on can only be reached from this machine."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def make_token() -> str:
    """Return a random word that cannot be guessed."""
    return secrets.token_urlsafe(16)


class AccessGuard:
    """Lets through what comes from the right page, and turns everything else away.

    A page of another host that is open in the same browser must not command the tracker: requests
    must name a host of this server, and a WebSocket must come from a page of that host. Where
    others than this machine can reach the server, they must bring the token: once in the address
    (``?token=...``), which then stays in a cookie.

    Parameters
    ----------
    token : str or None
        Token that a request must carry. None: the server listens on loopback alone, and the Host
        header must name this machine.
    """

    def __init__(self, application: Application, token: str | None = None) -> None:
        self._application = application
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        if scope["type"] not in ("http", "websocket"):
            await self._application(scope, receive, send)
            return
        headers = {
            key.decode("latin-1"): value.decode("latin-1") for key, value in scope["headers"]
        }
        if not self._is_allowed(scope, headers):
            await _refuse(scope, receive, send)
            return
        if self._token is not None and scope["type"] == "http":
            send = _with_cookie(send, _cookie_name(headers.get("host", "")), self._token)
        await self._application(scope, receive, send)

    def _is_allowed(self, scope: Scope, headers: MutableMapping[str, str]) -> bool:
        host = headers.get("host", "")
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return False
        if self._token is None:
            return is_loopback(_parts_of(host)[0])
        given = [*parse_qs(scope["query_string"].decode("latin-1")).get("token", ())]
        given += _cookie_of(headers, _cookie_name(host))
        return any(secrets.compare_digest(word.encode(), self._token.encode()) for word in given)


def _parts_of(host: str) -> tuple[str, str]:
    """Return name and port of a Host header; the port is empty where it names none."""
    name, colon, port = host.rpartition(":")
    is_port = bool(colon) and port.isascii() and port.isdigit()
    return (name.strip("[]"), port) if is_port else (host.strip("[]"), "")


def _cookie_name(host: str) -> str:
    return COOKIE + _parts_of(host)[1]


def _cookie_of(headers: MutableMapping[str, str], name: str) -> list[str]:
    try:
        cookie = SimpleCookie(headers.get("cookie", "")).get(name)
    except CookieError:
        return []
    return [cookie.value] if cookie is not None else []


def _with_cookie(send: Send, name: str, token: str) -> Send:
    value = f"{name}={token}; Path=/; HttpOnly; SameSite=Strict".encode("latin-1")

    async def send_with_cookie(message: Message) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", ()), (b"set-cookie", value)]
        await send(message)

    return send_with_cookie


async def _refuse(scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": REFUSED_BY_CLOSING})
        return
    text = b"refused: open the address that cable-tracker printed, with its token if it has one\n"
    kind = (b"content-type", b"text/plain; charset=utf-8")
    await send({"type": "http.response.start", "status": 403, "headers": [kind]})
    await send({"type": "http.response.body", "body": text})
