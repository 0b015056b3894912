"""Staff's sockets: the list of who is where, and one running trial, both read-only.

What a page may say is hello and ping; everything else closes the socket with a reason.
"""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from starlette.datastructures import Headers

from server.live import wire
from server.live.connection import Allowance, Receive, Talk, refuse_socket, serve_socket
from server.live.endpoint import HELLO_WITHIN_S
from server.live.hall import Hall
from server.live.line import Line
from server.live.outbox import Outbox, Send, SpectatorOutbox
from server.live.wire import CloseCode, WireError
from server.problems import problem_of
from study.errors import StudyError

logger = logging.getLogger(__name__)
MESSAGES_PER_S, MESSAGES_BURST = 30.0, 120.0
TELL_EVERY_S = 1.0

Identify = Callable[[Mapping[str, Any]], Awaitable[str]]
Begin = Callable[[Mapping[str, Any], SpectatorOutbox], "StaffTalk"]
Describe = Callable[[str], Awaitable[Mapping[str, Any]]]


class StaffEndpoint:
    """Serves sockets of signed-in staff; `begin` makes the talk for a scope."""

    def __init__(
        self, same_origin: Callable[[Headers], bool], identify: Identify, begin: Begin
    ) -> None:
        self._same_origin = same_origin
        self._identify = identify
        self._begin = begin

    async def __call__(self, scope: Mapping[str, Any], receive: Receive, send: Send) -> None:
        """Serve one socket from handshake to close."""
        await receive()
        if not self._same_origin(Headers(raw=list(scope["headers"]))):
            await refuse_socket(send)
            return

        def begin(line: Line | None) -> tuple[Outbox, Talk]:
            outbox = SpectatorOutbox(send, line)
            talk = self._begin(scope, outbox)
            talk.identify = lambda: self._identify(scope)
            return outbox, talk

        await serve_socket(scope, receive, send, begin)


class StaffTalk:
    """Hello, pings, and what a subclass does once it is known who asks."""

    identify: Callable[[], Awaitable[str]]

    def __init__(self, outbox: SpectatorOutbox) -> None:
        self.outbox = outbox
        self._task: asyncio.Task[None] | None = None
        self._allowance = Allowance(MESSAGES_PER_S, MESSAGES_BURST)
        self._patience = asyncio.get_running_loop().call_later(HELLO_WITHIN_S, self._lose_patience)

    async def begin(self) -> None:
        """Speak to the page until there is nothing more to say."""
        raise NotImplementedError

    def end(self) -> None:
        """The socket is gone."""

    def take(self, name: str, record: Mapping[str, Any]) -> None:
        """A message besides hello and ping."""
        del record
        raise WireError("hello or ping", name)

    def hear(self, frame: str | bytes) -> None:
        """Take one message of the page; one that does not fit ends the socket."""
        if self.outbox.closing.done():
            return
        try:
            self._allowance.spend()
            self._hear(frame)
        except WireError as problem:
            self.outbox.close(problem.code, str(problem))
        except Exception:
            logger.exception("a socket of staff failed")
            self.outbox.close(CloseCode.TRY_LATER, "the server had a fault; try again")

    def leave(self, code: int) -> None:
        """The socket ends."""
        del code
        self._patience.cancel()
        if self._task is not None:
            self._task.cancel()
        self.end()

    def _hear(self, frame: str | bytes) -> None:
        if isinstance(frame, bytes) or len(frame) > wire.MAX_CLIENT_BYTES:
            raise WireError("a short text message", f"{len(frame)} bytes")
        try:
            record = json.loads(frame)
        except (ValueError, RecursionError):
            raise WireError("a JSON object", "a text that is no JSON") from None
        name = record.get("type") if isinstance(record, dict) else None
        if name == "ping":
            sent_ms = wire.read_field("ping", record, "sent_ms", float)
            self.outbox.send_text(wire.encode_pong(sent_ms))
        elif name == "hello" and self._task is None:
            self._patience.cancel()
            self._task = asyncio.create_task(self._run())
        elif self._task is None:
            raise WireError("“hello” first", wire.brief(name))
        else:
            self.take(str(name)[:40], record)

    async def _run(self) -> None:
        try:
            await self.identify()
            await self.begin()
        except StudyError as problem:
            self.refuse(CloseCode(problem_of(problem).close_code), problem.sentence)
        except WireError as problem:
            self.outbox.close(problem.code, str(problem))
        except Exception:
            logger.exception("a socket of staff failed")
            self.refuse(CloseCode.TRY_LATER, "the server had a fault; try again")

    def refuse(self, code: CloseCode, sentence: str) -> None:
        """Say why, and end the socket."""
        self.outbox.send_text(wire.encode_error(sentence))
        self.outbox.close(code, sentence)

    def _lose_patience(self) -> None:
        self.outbox.close(CloseCode.MALFORMED, "wanted “hello” first, got nothing")


class PeopleTalk(StaffTalk):
    """Tells who is where, once a second, as long as the account is in order."""

    def __init__(self, outbox: SpectatorOutbox, study_id: str, describe: Describe) -> None:
        super().__init__(outbox)
        self._study_id = study_id
        self._describe = describe

    async def begin(self) -> None:
        """Tell and wait, over and over."""
        while True:
            await self.identify()
            self.outbox.send_text(wire.encode_text(await self._describe(self._study_id)))
            await asyncio.sleep(TELL_EVERY_S)


class SpectatorTalk(StaffTalk):
    """Shows one running trial as its participant's page is shown it."""

    def __init__(self, outbox: SpectatorOutbox, hall: Hall, trial_id: str) -> None:
        super().__init__(outbox)
        self._hall = hall
        self._trial_id = trial_id

    async def begin(self) -> None:
        """Join the audience."""
        room = self._hall.rooms.get(self._trial_id)
        if room is None:
            self.refuse(CloseCode.TRY_LATER, "this trial is not running at the moment")
            return
        room.watch(self.outbox)

    def end(self) -> None:
        """Leave the audience."""
        room = self._hall.rooms.get(self._trial_id)
        if room is not None:
            room.leave(self.outbox, CloseCode.NORMAL)
