"""The web server of both windows."""

from __future__ import annotations

import asyncio
import signal
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from nicegui import app, background_tasks, ui
from starlette.websockets import WebSocket

from cable_tracker.errors import GuiError
from cable_tracker.gui.web.access import AccessGuard, is_loopback, make_token
from cable_tracker.gui.web.frame_channel import FrameChannel

NO_SUCH_CHANNEL = 4404
"""WebSocket's code, of those free for applications, for a channel of an earlier server."""

POLL = 0.02
"""Time between two looks whether the port answers [s]."""

EVERYWHERE = frozenset({"0.0.0.0", "::"})
"""Addresses that stand for all of this machine's."""


@dataclass(frozen=True, slots=True)
class Listening:
    """Address and token of the server.

    Attributes
    ----------
    host : str
        Address or name of an interface of this machine.
    port : int
        TCP port; 0 is any free one.
    token : str or None
        Token that a browser must present; None on loopback alone.
    """

    host: str
    port: int
    token: str | None = None

    @property
    def url(self) -> str:
        """The address to open in a browser."""
        host = socket.gethostname() if self.host in EVERYWHERE else self.host
        query = f"?token={self.token}" if self.token is not None else ""
        return f"http://{_in_address(host)}:{self.port}/{query}"

    def ssh_line(self) -> str:
        """Return the command that makes the page appear on the machine one sits at."""
        is_local = self.host in EVERYWHERE or self.host == "localhost"
        host = "127.0.0.1" if is_local else self.host
        return f"ssh -L {self.port}:{_in_address(host)}:{self.port} {socket.gethostname()}"


def _in_address(host: str) -> str:
    """Return a host as it stands before a port: an address of IPv6 in brackets."""
    return f"[{host}]" if ":" in host else host


def listen_on(host: str, port: int) -> Listening:
    """Return where to listen: a free port, and a token where others can reach it.

    Raises
    ------
    GuiError
        The port is taken, or the address is none of this machine.
    """
    token = None if is_loopback(host) else make_token()
    return Listening(host, claim_port(host, port), token)


def claim_port(host: str, port: int) -> int:
    """Return a port that is free.

    Raises
    ------
    GuiError
        It is taken, or the address is none of this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise GuiError(
                f"cannot listen on {host} port {port} ({error.strerror}); choose another with"
                " --port, or --port 0 for any free one"
            ) from error
        return int(probe.getsockname()[1])


class Channels:
    """The channels that browsers can ask for."""

    def __init__(self) -> None:
        self._channels: dict[str, FrameChannel] = {}

    def add(self, channel: FrameChannel) -> FrameChannel:
        """Let browsers reach a channel."""
        self._channels[channel.name] = channel
        return channel

    def remove(self, channel: FrameChannel) -> None:
        """Let no further browser reach a channel."""
        self._channels.pop(channel.name, None)

    async def serve(self, websocket: WebSocket, name: str) -> None:
        """Serve one browser, or turn it away."""
        channel = self._channels.get(name)
        if channel is None:
            await websocket.close(NO_SUCH_CHANNEL)
            return
        await channel.serve(websocket)


async def _when_listening(listening: Listening, started: Callable[[], None]) -> None:
    """Tell when the port answers: uvicorn says that it has begun a little earlier."""
    host = "localhost" if listening.host in EVERYWHERE else listening.host
    while True:
        try:
            _, writer = await asyncio.open_connection(host, listening.port)
        except OSError:
            await asyncio.sleep(POLL)
        else:
            writer.close()
            started()
            return


@contextmanager
def _signals_end_the_server() -> Iterator[None]:
    """Let uvicorn take SIGINT and SIGTERM; it raises them again, without effect, at its end."""

    def has_ended(_number: int, _frame: FrameType | None) -> None:
        pass

    before = {
        number: signal.signal(number, has_ended) for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def serve(
    page: Callable[[], None],
    channels: Channels,
    listening: Listening,
    title: str,
    *,
    started: Callable[[], None] = lambda: None,
    stopped: Callable[[], None] = lambda: None,
) -> None:
    """Serve one page until a signal ends it.

    Parameters
    ----------
    page : callable
        Builds the page, anew for each browser.
    listening : Listening
        Address to listen on; see `claim_port`.
    started, stopped : callable
        Called when the server has begun to listen, and when it has ended.
    """
    if listening.token is None and not is_loopback(listening.host):
        raise GuiError(f"{listening.host} can be reached by others; give it a token")
    ui.page("/", title=title, dark=True)(page)
    app.add_api_websocket_route("/frames/{name}", channels.serve)
    app.add_middleware(AccessGuard, token=listening.token)
    app.on_startup(lambda: background_tasks.create(_when_listening(listening, started)))
    app.on_shutdown(stopped)
    with _signals_end_the_server():
        ui.run(
            host=listening.host,
            port=listening.port,
            title=title,
            reload=False,
            show=False,
            show_welcome_message=False,
            dark=True,
            reconnect_timeout=10.0,
        )


def typed_path(text: str) -> Path:
    """Return the path on the server; ``~`` is the home folder there.

    Raises
    ------
    GuiError
        Nothing is typed, or it names the home folder of a user that the server does not know.
    """
    if not text.strip():
        # As a path it would be the folder that the server was started in.
        raise GuiError("no path is given; type one")
    try:
        return Path(text.strip()).expanduser()
    except RuntimeError as error:
        raise GuiError(f"{text.strip()}: no such home folder; write the whole path") from error
