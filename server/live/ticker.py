"""The one clock that drives all rooms: 30 steps a second, in four groups a quarter period apart.

Deadlines are absolute, so a late slot does not delay those after it. After a stall of up to half a
second the missed slots are made up; beyond that the time is given up and the rooms are told.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterator
from typing import Protocol

from server.live.clock import Clock
from server.live.lateness import Lateness
from server.live.wire import TICK_HZ

logger = logging.getLogger(__name__)

GROUPS = 4
SLOT_S = 1.0 / (TICK_HZ * GROUPS)
MAX_CATCH_UP_S = 0.5


class Ticked(Protocol):
    """What the ticker needs of a room."""

    def advance(self) -> None:
        """A period of 1/30 s has passed."""
        ...

    def note_lag(self, lost_s: float) -> None:
        """So much time was given up."""
        ...

    def note_late(self, late_s: float) -> None:
        """The tick that comes now is so much later than it should be."""
        ...


class Ticker:
    """Calls `advance` on every room 30 times a second.

    A room that raises is taken out and handed to `on_failure`; the others go on.
    """

    def __init__(self, clock: Clock, on_failure: Callable[[Ticked, Exception], None]) -> None:
        self.lateness = Lateness()
        self._clock = clock
        self._on_failure = on_failure
        self._groups: list[list[Ticked]] = [[] for _ in range(GROUPS)]
        self._next_s = clock.now_s()
        self._slot = 0

    def __iter__(self) -> Iterator[Ticked]:
        return (room for group in self._groups for room in group)

    def add(self, room: Ticked) -> None:
        """Drive this room too; it joins the smallest group."""
        min(self._groups, key=len).append(room)

    def remove(self, room: Ticked) -> None:
        """Stop driving a room; unknown ones are ignored."""
        for group in self._groups:
            if room in group:
                group.remove(room)

    async def run(self) -> None:
        """Tick until cancelled."""
        self._next_s = self._clock.now_s() + SLOT_S
        while True:
            await asyncio.sleep(max(0.0, self._next_s - self._clock.now_s()))
            self.run_slot()

    def run_slot(self) -> None:
        """Tick the group whose turn it is, if its time has come."""
        started_s = self._clock.now_s()
        if started_s < self._next_s:
            return
        late_s = started_s - self._next_s
        if late_s > MAX_CATCH_UP_S:
            self._give_up(late_s)
        group = self._groups[self._slot % GROUPS]
        for room in tuple(group):
            room_late_s = self._clock.now_s() - self._next_s
            self.lateness.add(room_late_s)
            try:
                room.note_late(room_late_s)
                room.advance()
            except Exception as problem:
                logger.exception("a trial failed in its tick")
                self.remove(room)
                self._on_failure(room, problem)
        self._slot += 1
        self._next_s += SLOT_S

    def _give_up(self, late_s: float) -> None:
        self.lateness.lost_s += late_s
        self._next_s += late_s
        for room in self:
            room.note_lag(late_s)
