"""One participant's socket as a state machine: wants hello -> opening -> joined -> closed.

It is an ASGI application, to be mounted at `/p/{token}/live`. Whatever does not fit the state
closes the socket with a code and a reason that says what was wanted; no other room notices.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from typing import Any, Protocol

from starlette.datastructures import Headers

from server.live import wire
from server.live.line import find_line
from server.live.outbox import Outbox, Send
from server.live.sink import Sink
from server.live.wire import CloseCode, WireError
from server.problems import problem_of
from study.errors import StudyError

logger = logging.getLogger(__name__)

Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
HELLO_WITHIN_S = 15.0
CLOSE_WITHIN_S = 5.0
MESSAGES_PER_S = 200.0
MESSAGES_BURST = 600.0
NO_STATUS = 1005


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
    """Serves participants' sockets. `same_origin` judges the handshake's headers."""

    def __init__(self, rooms: RoomOpener, same_origin: Callable[[Headers], bool]) -> None:
        self._rooms = rooms
        self._same_origin = same_origin

    async def __call__(self, scope: Mapping[str, Any], receive: Receive, send: Send) -> None:
        """Serve one socket from handshake to close."""
        await receive()
        if not self._same_origin(Headers(raw=list(scope["headers"]))):
            await send({"type": "websocket.close", "code": CloseCode.WRONG_ORIGIN})
            return
        await send({"type": "websocket.accept"})
        token = str(scope["path_params"]["token"])
        line = find_line(scope)
        outbox = Outbox(send, f"{scope.get('root_path', '')}/p/{token}", line)
        session = Session(self._rooms, token, outbox)
        if line is not None:
            line.listen(session.hear)
        writer = asyncio.create_task(outbox.run())
        reader = asyncio.create_task(session.read(receive))
        try:
            await asyncio.wait({reader, outbox.closing}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            session.leave()
            reader.cancel()
            if outbox.closing.done():
                await asyncio.wait({writer}, timeout=CLOSE_WITHIN_S)
            writer.cancel()
            await asyncio.gather(reader, writer, return_exceptions=True)


class Session:
    """What one socket has said so far and what it may say next."""

    def __init__(self, rooms: RoomOpener, token: str, outbox: Outbox) -> None:
        self._rooms = rooms
        self._token = token
        self._outbox = outbox
        self._room: JoinedRoom | None = None
        self._opening: asyncio.Task[None] | None = None
        self._code = NO_STATUS
        self._is_greeted = False
        self._patience = asyncio.get_running_loop().call_later(HELLO_WITHIN_S, self._lose_patience)
        self._allowance = MESSAGES_BURST
        self._allowance_s = 0.0

    async def read(self, receive: Receive) -> None:
        """Read until the socket ends; what its line hears directly does not come by here."""
        while True:
            message = await receive()
            if message["type"] == "websocket.disconnect":
                self._code = message.get("code") or NO_STATUS
                return
            data = message.get("bytes")
            self.hear(message["text"] if data is None else data)

    def hear(self, frame: str | bytes) -> None:
        """Take one message of the client; one that does not fit ends the socket."""
        if self._outbox.closing.done():
            return
        try:
            self._check_rate()
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

    def leave(self) -> None:
        """The socket ends: its room, if it has one, hears of it."""
        self._patience.cancel()
        if self._opening is not None:
            self._opening.cancel()
        if self._room is not None:
            room, self._room = self._room, None
            room.leave(self._outbox, self._code)

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

    def _check_rate(self) -> None:
        now_s = time.perf_counter()
        gained = (now_s - self._allowance_s) * MESSAGES_PER_S
        self._allowance = min(MESSAGES_BURST, self._allowance + gained) - 1.0
        self._allowance_s = now_s
        if self._allowance < 0.0:
            raise WireError(f"at most {MESSAGES_PER_S:.0f} messages a second", "more")
