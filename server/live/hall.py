"""All running trials of this process: who enters, what drives them, what stores them."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING

from server.live.clock import Clock, SystemClock
from server.live.journal_writer import JournalWriter
from server.live.ports import OpenTrial, TrialBatch, TrialDesk
from server.live.room import Room
from server.live.ticker import Ticked, Ticker
from server.live.wire import CloseCode
from study.errors import WrongMoment

if TYPE_CHECKING:
    from collections.abc import Iterable

logger = logging.getLogger(__name__)

Prepare = Callable[[], Awaitable[None]]
GAVE_UP = "this trial had a fault and was paused; try again"


class StillStoring(WrongMoment):
    """A trial cannot be opened before everything that was played of it is stored."""

    def __init__(self) -> None:
        super().__init__(
            "the last moments of this trial are still being stored",
            next_step="The page tries again by itself.",
        )


class Hall:
    """Rooms by trial. A trial is opened once, however many sockets ask for it at the same time.

    `prepare` gets the compiled world ready; sockets are answered meanwhile and their trials open
    when it is done. Call `start` in the server's event loop and `stop` at its end.
    """

    def __init__(self, desk: TrialDesk, prepare: Prepare, clock: Clock | None = None) -> None:
        self.clock = clock or SystemClock()
        self.rooms: dict[str, Room] = {}
        self.ticker = Ticker(self.clock, self._give_up)
        self.writer = JournalWriter(desk, self, self.clock)
        self._desk = desk
        self._prepare = prepare
        self._preparing: asyncio.Task[None] | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self._opening: dict[str, asyncio.Task[Room]] = {}
        self._forgotten = 0

    @property
    def is_ready(self) -> bool:
        """Whether trials can open at once: the world's code is compiled."""
        preparing = self._preparing
        return preparing is not None and preparing.done() and preparing.exception() is None

    async def start(self) -> None:
        """Begin to tick, to write and to compile."""
        self._preparing = asyncio.create_task(self._get_ready())
        self._tasks = [
            asyncio.create_task(self.ticker.run()),
            asyncio.create_task(self.writer.run()),
        ]

    async def stop(self) -> None:
        """Pause every trial, close every socket, store everything."""
        async with self.writer.between_commits:
            for task in (*self._tasks, *self._opening.values(), self._preparing):
                if task is not None:
                    task.cancel()
        for room in self.rooms.values():
            room.shut_down(CloseCode.RESTARTING, "the server restarts; the trial is paused")
        with contextlib.suppress(asyncio.CancelledError):
            await asyncio.gather(*self._tasks, return_exceptions=True)
        if not await self.writer.flush():
            await self.writer.flush()

    async def enter(self, token: str) -> Room:
        """The room of the participant's current trial; raises what the desk raises."""
        await self.settle()
        while True:
            await self._store_owed()
            forgotten = self._forgotten
            opened = await self._desk.open_trial(token)
            trial_id = opened.setup.trial_id
            if trial_id in self.rooms:
                return self.rooms[trial_id]
            if trial_id not in self._opening and forgotten != self._forgotten:
                continue  # it may have ended between the desk's answer and now
            task = self._opening.get(trial_id)
            if task is None:
                task = self._opening[trial_id] = asyncio.create_task(self._open(opened))
            return await asyncio.shield(task)

    async def settle(self) -> None:
        """Return once trials can open: the world is compiled, and what was played is stored.

        Raises StillStoring.
        """
        if self._preparing is not None:
            await asyncio.shield(self._preparing)
        await self._store_owed()

    def admit(self, room: Room) -> None:
        """Drive and store a room that somebody else has opened."""
        self.rooms[room.setup.trial_id] = room
        self.ticker.add(room)

    async def _store_owed(self) -> None:
        if self.writer.owes and not await self.writer.flush():
            raise StillStoring

    async def _open(self, opened: OpenTrial) -> Room:
        from server.live.opening import open_room  # loads numba, so not before it is needed

        trial_id = opened.setup.trial_id
        try:
            room = await open_room(opened, self.clock)
            self.admit(room)
            return room
        finally:
            del self._opening[trial_id]

    async def _get_ready(self) -> None:
        try:
            await self._prepare()
        except Exception:
            logger.exception("the world could not be compiled; no trial can open")
            raise

    # ---- what the writer tells ----------------------------------------------------------------

    def all_rooms(self) -> Iterable[Room]:
        """Every room there is now."""
        return tuple(self.rooms.values())

    def note_committed(self, batch: TrialBatch) -> None:
        """A room hears that what it did until then is stored."""
        room = self.rooms.get(batch.trial_id)
        if room is not None:
            room.note_committed(batch)

    def forget(self, room: Room) -> None:
        """Stop driving a room."""
        self._forgotten += 1
        self.rooms.pop(room.setup.trial_id, None)
        self.ticker.remove(room)

    def close_refused(self, trial_id: str) -> None:
        """Close the room of a trial that cannot be stored."""
        self._close(trial_id, CloseCode.TRY_LATER, "this trial could not be stored; open it again")

    def close_over(self, trial_id: str) -> None:
        """Close the room of a trial that has ended elsewhere."""
        self._close(trial_id, CloseCode.NO_TRIAL, "this trial is over; load the page again")

    def _close(self, trial_id: str, code: CloseCode, reason: str) -> None:
        room = self.rooms.get(trial_id)
        if room is not None:
            self.forget(room)
            room.shut_down(code, reason)

    def _give_up(self, ticked: Ticked, problem: Exception) -> None:
        for room in self.all_rooms():
            if room is ticked:
                self.forget(room)
                room.shut_down(CloseCode.TRY_LATER, GAVE_UP)
                self.writer.keep(room.take_batch())
