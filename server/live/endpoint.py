"""One participant's socket as a state machine: wants hello -> opening -> joined -> closed.

It is an ASGI application, to be mounted at `/p/{token}/live`, and at `/w/{token}/live` for the
worker of a learning run, who takes part in the same way. Whatever does not fit the state closes
the socket with a code and a reason that says what was wanted; no other room notices.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from starlette.datastructures import Headers

from server.live import wire
from server.live.connection import Allowance, Receive, refuse_socket, serve_socket
from server.live.line import Line
from server.live.outbox import Outbox, Send
from server.live.sink import Sink
from server.live.wire import CloseCode, WireError
from server.problems import problem_of
from study.errors import StudyError

logger = logging.getLogger(__name__)

HELLO_WITHIN_S = 15.0
MESSAGES_PER_S = 200.0
MESSAGES_BURST = 600.0


class JoinedRoom(Protocol):
    """What a socket needs of a room."""

    def join(self, sink: Sink) -> None:
        """Take the trial over."""
        ...

    def leave(self, sink: Sink, code: int) -> None:
        """The socket is gone."""
        ...

    def take_ready(self) -> None:
        """The client is ready."""
        ...

    def take_input(self, message: wire.Input) -> None:
        """Input frames came."""
        ...

    def take_attention(self, message: wire.Attention) -> None:
        """The page's visibility or focus changed."""
        ...

    def take_context(self, message: wire.Context) -> None:
        """The graphics context changed."""
        ...

    def take_quality(self, message: wire.Quality) -> None:
        """The client tells how the picture and the connection are."""
        ...

    def take_ping(self) -> None:
        """The client is alive."""
        ...


class RoomOpener(Protocol):
    """Where a token leads: the participant's running trial, opened if need be."""

    async def enter(self, token: str) -> JoinedRoom:
        """The room of the participant's current trial. Raises StudyError."""
        ...


class LiveEndpoint:
    """Serves participants' sockets. `same_origin` judges the handshake's headers.

    `page` is the address of the participant's page without the token.
    """

    def __init__(
        self, rooms: RoomOpener, same_origin: Callable[[Headers], bool], page: str = "/p"
    ) -> None:
        self._rooms = rooms
        self._same_origin = same_origin
        self._page = page

    async def __call__(self, scope: Mapping[str, Any], receive: Receive, send: Send) -> None:
        """Serve one socket from handshake to close."""
        await receive()
        if not self._same_origin(Headers(raw=list(scope["headers"]))):
            await refuse_socket(send)
            return
        token = str(scope["path_params"]["token"])
        page = f"{scope.get('root_path', '')}{self._page}/{token}"

        def begin(line: Line | None) -> tuple[Outbox, Session]:
            outbox = Outbox(send, page, line)
            return outbox, Session(self._rooms, token, outbox)

        await serve_socket(scope, receive, send, begin)


class Session:
    """What one socket has said so far and what it may say next."""

    def __init__(self, rooms: RoomOpener, token: str, outbox: Outbox) -> None:
        self._rooms = rooms
        self._token = token
        self._outbox = outbox
        self._room: JoinedRoom | None = None
        self._opening: asyncio.Task[None] | None = None
        self._is_greeted = False
        self._patience = asyncio.get_running_loop().call_later(HELLO_WITHIN_S, self._lose_patience)
        self._allowance = Allowance(MESSAGES_PER_S, MESSAGES_BURST)

    def hear(self, frame: str | bytes) -> None:
        """Take one message of the client; one that does not fit ends the socket."""
        if self._outbox.closing.done():
            return
        try:
            self._allowance.spend()
            message = wire.parse_text(frame) if isinstance(frame, str) else wire.parse_input(frame)
            if self._is_greeted:
                self._take(message)
            else:
                self._greet(message)
        except WireError as problem:
            self._outbox.close(problem.code, str(problem))
        except Exception:
            logger.exception("a live socket failed")
            self._outbox.close(CloseCode.TRY_LATER, "the server had a fault; try again")

    def leave(self, code: int) -> None:
        """The socket ends: its room, if it has one, hears of it."""
        self._patience.cancel()
        if self._opening is not None:
            self._opening.cancel()
        if self._room is not None:
            room, self._room = self._room, None
            room.leave(self._outbox, code)

    def _lose_patience(self) -> None:
        self._outbox.close(CloseCode.MALFORMED, "wanted “hello” first, got nothing")

    def _greet(self, message: wire.TextMessage | wire.Input) -> None:
        if not isinstance(message, wire.Hello):
            raise WireError("“hello” first", type(message).__name__.lower())
        if message.version != wire.PROTOCOL_VERSION:
            raise WireError(
                f"protocol version {wire.PROTOCOL_VERSION} (reload the page)", str(message.version)
            )
        self._patience.cancel()
        self._is_greeted = True
        self._opening = asyncio.create_task(self._open())

    async def _open(self) -> None:
        try:
            room = await self._rooms.enter(self._token)
        except StudyError as problem:
            self._refuse(CloseCode(problem_of(problem).close_code), problem.sentence)
        except Exception:
            logger.exception("a trial could not be opened")
            self._refuse(CloseCode.TRY_LATER, "the trial cannot be opened now; try again soon")
        else:
            self._room = room
            room.join(self._outbox)

    def _refuse(self, code: CloseCode, sentence: str) -> None:
        self._outbox.send_text(wire.encode_error(sentence))
        self._outbox.close(code, sentence)

    def _take(self, message: wire.TextMessage | wire.Input) -> None:
        room = self._room
        if isinstance(message, wire.Input):
            if room is None:
                raise WireError("“ready” before any input", "an input message")
            room.take_input(message)
        elif isinstance(message, wire.Ping):
            self._outbox.send_text(wire.encode_pong(message.sent_ms))
            if room is not None:
                room.take_ping()
        elif isinstance(message, wire.Hello):
            raise WireError("“hello” once", "another hello")
        elif isinstance(message, wire.Ready):
            if room is None:
                raise WireError("“ready” after the welcome", "ready")
            room.take_ready()
        elif room is not None:
            if isinstance(message, wire.Attention):
                room.take_attention(message)
            elif isinstance(message, wire.Quality):
                room.take_quality(message)
            else:
                room.take_context(message)
