"""What every talk over a live socket has in common, whoever is at its other end.

A talk wants a greeting within a while, opens what the socket is about, and then takes messages.
What does not fit ends the socket with a code and a reason; a fault of ours is logged and ends it
with “try again”, so that no other room notices.
"""

from __future__ import annotations

import asyncio
import logging
from abc import ABC, abstractmethod
from collections.abc import Coroutine
from typing import Any

from server.live import wire
from server.live.connection import Allowance
from server.live.outbox import Outbox
from server.live.wire import CloseCode, WireError
from server.problems import problem_of
from study.errors import StudyError

logger = logging.getLogger(__name__)

HELLO_WITHIN_S = 15.0
FAULT = "the server had a fault; try again"


class GreetedTalk(ABC):
    """One end of a socket: its outbox, its patience, its allowance of messages."""

    def __init__(self, outbox: Outbox, allowance: Allowance) -> None:
        self.outbox = outbox
        self._allowance = allowance
        self._opening: asyncio.Task[None] | None = None
        self._patience = asyncio.get_running_loop().call_later(HELLO_WITHIN_S, self._lose_patience)

    @abstractmethod
    def take(self, frame: str | bytes) -> None:
        """Take one message. Raises WireError for one that does not fit the state."""

    @abstractmethod
    def end(self, code: int) -> None:
        """The socket is gone: let go of what it had joined."""

    @property
    def is_greeted(self) -> bool:
        """Whether “hello” was said."""
        return self._opening is not None

    def hear(self, frame: str | bytes) -> None:
        """Take one message of the other end; one that does not fit ends the socket."""
        if self.outbox.closing.done():
            return
        try:
            self._allowance.spend()
            self.take(frame)
        except WireError as problem:
            self.outbox.close(problem.code, str(problem))
        except StudyError as problem:
            self.refuse(problem)
        except Exception:
            logger.exception("a live socket failed")
            self.outbox.close(CloseCode.TRY_LATER, FAULT)

    def leave(self, code: int) -> None:
        """The socket ends with this close code."""
        self._patience.cancel()
        if self._opening is not None:
            self._opening.cancel()
        self.end(code)

    def open(self, opening: Coroutine[Any, Any, None]) -> None:
        """“hello” was said: open what the socket is about; what fails is told and ends it."""
        self._patience.cancel()
        self._opening = asyncio.create_task(self._watch_over(opening))

    def refuse(self, problem: StudyError) -> None:
        """Tell what is wrong, and end the socket with the code of such a problem."""
        self.turn_away(CloseCode(problem_of(problem).close_code), problem.sentence)

    def turn_away(self, code: CloseCode, sentence: str) -> None:
        """Say why, and end the socket."""
        self.outbox.send_text(wire.encode_error(sentence))
        self.outbox.close(code, sentence)

    async def _watch_over(self, opening: Coroutine[Any, Any, None]) -> None:
        try:
            await opening
        except WireError as problem:
            self.outbox.close(problem.code, str(problem))
        except StudyError as problem:
            self.refuse(problem)
        except Exception:
            logger.exception("what a live socket is about could not be opened")
            self.turn_away(CloseCode.TRY_LATER, "this cannot be opened now; try again soon")

    def _lose_patience(self) -> None:
        self.outbox.close(CloseCode.MALFORMED, "wanted “hello” first, got nothing")
