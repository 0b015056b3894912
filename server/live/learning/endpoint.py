"""An expert's socket as a state machine: wants hello -> opening -> joined -> closed.

It is an ASGI application, to be mounted at `/expert/runs/{run}/live`. Who somebody is, the
server's sign-in tells; a page that may not come is told so and closed with 4403.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import TYPE_CHECKING, Any

from starlette.datastructures import Headers

from server.live.connection import Allowance, Receive, serve_socket
from server.live.learning import wire
from server.live.learning.ports import RunEnded
from server.live.learning.runs import LearningRuns
from server.live.line import Line
from server.live.outbox import Send, SpectatorOutbox
from server.live.talk import GreetedTalk
from server.live.wire import CloseCode, Ping, WireError, encode_pong

if TYPE_CHECKING:  # loads numba, so not before a run is opened
    from server.live.learning.experts import Seat
    from server.live.learning.run import LearningRun

MESSAGES_PER_S = 30.0
MESSAGES_BURST = 120.0
SIGN_IN = "please sign in as an expert or administrator, then load the page again"

Identify = Callable[[Mapping[str, Any]], Awaitable[str]]
"""The account's name for a socket's scope; raises Refused when nobody fit is signed in."""


class ExpertEndpoint:
    """Serves experts' sockets. `same_origin` judges the handshake's headers."""

    def __init__(
        self, runs: LearningRuns, same_origin: Callable[[Headers], bool], identify: Identify
    ) -> None:
        self._runs = runs
        self._same_origin = same_origin
        self._identify = identify

    async def __call__(self, scope: Mapping[str, Any], receive: Receive, send: Send) -> None:
        """Serve one socket from handshake to close."""
        run_id = str(scope["path_params"]["run"])

        def begin(line: Line | None) -> tuple[SpectatorOutbox, ExpertTalk]:
            outbox = SpectatorOutbox(send, line)
            return outbox, ExpertTalk(self._runs, run_id, outbox, lambda: self._identify(scope))

        await serve_socket(scope, receive, send, self._same_origin, begin)


class ExpertTalk(GreetedTalk):
    """What one expert's socket has said so far and what it may say next."""

    def __init__(
        self,
        runs: LearningRuns,
        run_id: str,
        outbox: SpectatorOutbox,
        identify: Callable[[], Awaitable[str]],
    ) -> None:
        super().__init__(outbox, Allowance(MESSAGES_PER_S, MESSAGES_BURST))
        self._runs = runs
        self._run_id = run_id
        self._identify = identify
        self._run: LearningRun | None = None
        self._seat: Seat | None = None

    def take(self, frame: str | bytes) -> None:
        """Take a message of the expert's page."""
        if isinstance(frame, bytes):
            raise WireError("a text message", f"{len(frame)} bytes")
        self._take(wire.parse_message(frame))

    def end(self, code: int) -> None:
        """The run, if there is one, hears of it."""
        del code
        if self._run is not None and self._seat is not None:
            self._run.leave(self._seat)
        self._run = self._seat = None

    def _take(self, message: wire.ExpertMessage) -> None:
        if isinstance(message, Ping):
            self.outbox.send_text(encode_pong(message.sent_ms))
        elif isinstance(message, wire.Hello):
            self._greet(message)
        elif self._run is None or self._seat is None:
            raise WireError("“run” to be answered first", type(message).__name__.lower())
        elif isinstance(message, wire.TakeLead):
            self._run.take_lead(self._seat)
        elif isinstance(message, wire.HandOver):
            self._run.hand_over(self._seat, message.to)
        else:
            self._run.edit(self._seat, message)

    def _greet(self, message: wire.Hello) -> None:
        if self.is_greeted:
            raise WireError("“hello” once", "another hello")
        if message.version != wire.EXPERT_VERSION:
            raise WireError(
                f"protocol version {wire.EXPERT_VERSION} (reload the page)", str(message.version)
            )
        self.open(self._enter(message))

    async def _enter(self, message: wire.Hello) -> None:
        name = await self._identify()
        try:
            run = await self._runs.open(self._run_id)
        except RunEnded:
            await self._show_ended(name, message.client)
            return
        self._seat = run.join(self.outbox, name, message.client)
        self._run = run

    async def _show_ended(self, name: str, client: str) -> None:
        """A run that is over still has its curve to show."""
        for text in await self._runs.describe_ended(self._run_id, (name, client)):
            self.outbox.send_text(text)
        self.outbox.close(CloseCode.NORMAL, "this learning run has ended")
