"""One participant's socket as a state machine: wants hello -> opening -> joined -> closed.

It is an ASGI application, to be mounted at `/p/{token}/live`, and at `/w/{token}/live` for the
worker of a learning run, who takes part in the same way. Whatever does not fit the state closes
the socket with a code and a reason that says what was wanted; no other room notices.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from starlette.datastructures import Headers

from server.live import wire
from server.live.connection import Allowance, Receive, serve_socket
from server.live.line import Line
from server.live.outbox import Outbox, Send
from server.live.sink import Sink
from server.live.talk import GreetedTalk
from server.live.wire import WireError

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
        token = str(scope["path_params"]["token"])
        page = f"{scope.get('root_path', '')}{self._page}/{token}"

        def begin(line: Line | None) -> tuple[Outbox, Session]:
            outbox = Outbox(send, page, line)
            return outbox, Session(self._rooms, token, outbox)

        await serve_socket(scope, receive, send, self._same_origin, begin)


class Session(GreetedTalk):
    """What one participant's socket has said so far and what it may say next."""

    def __init__(self, rooms: RoomOpener, token: str, outbox: Outbox) -> None:
        super().__init__(outbox, Allowance(MESSAGES_PER_S, MESSAGES_BURST))
        self._rooms = rooms
        self._token = token
        self._room: JoinedRoom | None = None

    def take(self, frame: str | bytes) -> None:
        """Take a message of the client."""
        message = wire.parse_text(frame) if isinstance(frame, str) else wire.parse_input(frame)
        if self.is_greeted:
            self._take(message)
        else:
            self._greet(message)

    def end(self, code: int) -> None:
        """The room, if there is one, hears of it."""
        if self._room is not None:
            room, self._room = self._room, None
            room.leave(self.outbox, code)

    def _greet(self, message: wire.TextMessage | wire.Input) -> None:
        if not isinstance(message, wire.Hello):
            raise WireError("“hello” first", type(message).__name__.lower())
        if message.version != wire.PROTOCOL_VERSION:
            raise WireError(
                f"protocol version {wire.PROTOCOL_VERSION} (reload the page)", str(message.version)
            )
        self.open(self._enter())

    async def _enter(self) -> None:
        room = await self._rooms.enter(self._token)
        self._room = room
        room.join(self.outbox)

    def _take(self, message: wire.TextMessage | wire.Input) -> None:
        room = self._room
        if isinstance(message, wire.Input):
            if room is None:
                raise WireError("“ready” before any input", "an input message")
            room.take_input(message)
        elif isinstance(message, wire.Ping):
            self.outbox.send_text(wire.encode_pong(message.sent_ms))
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
