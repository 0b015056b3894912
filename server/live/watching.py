"""Staff's sockets: the list of who is where, and one running trial, both read-only.

What a page may say is hello and ping; everything else closes the socket with a reason.
"""

from __future__ import annotations

import asyncio
import json
import logging
from abc import abstractmethod
from asyncio import FIRST_COMPLETED
from collections.abc import Awaitable, Callable, Mapping
from typing import TYPE_CHECKING, Any

from starlette.datastructures import Headers

from server.live import wire
from server.live.connection import Allowance, Receive, Talk, serve_socket
from server.live.hall import Hall
from server.live.line import Line
from server.live.outbox import Outbox, Send, SpectatorOutbox
from server.live.talk import GreetedTalk
from server.live.wire import CloseCode, WireError
from server.problems import Refused
from study.errors import StudyError

if TYPE_CHECKING:
    from server.live.room import Room

logger = logging.getLogger(__name__)

MESSAGES_PER_S, MESSAGES_BURST = 30.0, 120.0
TELL_EVERY_S = 1.0
IDENTIFY_EVERY_S = 5.0

Who = Callable[[], Awaitable[str]]
"""The account's name; raises Refused when nobody fit is signed in (any more)."""
Identify = Callable[[Mapping[str, Any]], Awaitable[str]]
Begin = Callable[[Mapping[str, Any], SpectatorOutbox, Who], "StaffTalk"]
Describe = Callable[[str], Awaitable[Mapping[str, Any]]]
IsOver = Callable[[str], Awaitable[bool]]
"""Whether a trial has ended, as it is stored; raises NotFound for one that there never was."""


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

        def begin(line: Line | None) -> tuple[Outbox, Talk]:
            outbox = SpectatorOutbox(send, line)
            return outbox, self._begin(scope, outbox, lambda: self._identify(scope))

        await serve_socket(scope, receive, send, self._same_origin, begin)


class StaffTalk(GreetedTalk):
    """Hello, pings, and what a subclass does once it is known who asks."""

    def __init__(self, outbox: SpectatorOutbox, who: Who) -> None:
        super().__init__(outbox, Allowance(MESSAGES_PER_S, MESSAGES_BURST))
        self.identify = who

    @abstractmethod
    async def begin(self) -> None:
        """Speak to the page until there is nothing more to say."""

    def act(self, name: str, record: Mapping[str, Any]) -> None:
        """Take a message besides hello and ping."""
        del record
        raise WireError("hello or ping", name)

    def end(self, code: int) -> None:
        """There is nothing to let go of."""

    def take(self, frame: str | bytes) -> None:
        """Take a message of the page."""
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
        elif name == "hello" and not self.is_greeted:
            self.open(self._begin())
        elif not self.is_greeted:
            raise WireError("“hello” first", wire.brief(name))
        else:
            self.act(str(name)[:40], record)

    async def _begin(self) -> None:
        """Speak for as long as the account is in order; a storage that is away is no refusal."""
        await self.identify()
        telling = asyncio.ensure_future(self.begin())
        try:
            while not self.outbox.closing.done():
                ends = {self.outbox.closing} if telling.done() else {self.outbox.closing, telling}
                await asyncio.wait(ends, timeout=IDENTIFY_EVERY_S, return_when=FIRST_COMPLETED)
                if telling.done():
                    telling.result()
                await self._identify_again()
        finally:
            telling.cancel()

    async def _identify_again(self) -> None:
        try:
            await self.identify()
        except Refused:
            raise
        except StudyError:
            logger.info("staff could not be identified again; their socket stays open")


class PeopleTalk(StaffTalk):
    """Tells who is where, once a second, as long as the account is in order."""

    def __init__(
        self, outbox: SpectatorOutbox, who: Who, study_id: str, describe: Describe
    ) -> None:
        super().__init__(outbox, who)
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

    def __init__(
        self, outbox: SpectatorOutbox, who: Who, hall: Hall, trial_id: str, is_over: IsOver
    ) -> None:
        super().__init__(outbox, who)
        self._hall = hall
        self._trial_id = trial_id
        self._is_over = is_over
        self._room: Room | None = None

    async def begin(self) -> None:
        """Join the audience; of a trial that has ended there is only the replay."""
        self._room = self._hall.rooms.get(self._trial_id)
        if self._room is not None:
            self._room.watch(self.outbox)
        elif await self._is_over(self._trial_id):
            self.turn_away(CloseCode.NO_TRIAL, "this trial is over")
        else:
            self.turn_away(CloseCode.TRY_LATER, "this trial is not running at the moment")

    def end(self, code: int) -> None:
        """Leave the audience that was joined, whatever room has this trial now."""
        if self._room is not None:
            self._room.leave(self.outbox, code)
