"""Stores all rooms' journals once a second; nothing is lost while the database is away."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Collection, Iterable
from typing import Protocol

from server.live.clock import Clock
from server.live.ports import TrialBatch, TrialDesk
from server.live.room import Room

logger = logging.getLogger(__name__)

PERIOD_S = 1.0
MAX_BACKOFF_S = 10.0
COMMIT_WITHIN_S = 20.0
ALONE_AFTER_FAILURES = 3


class RoomKeeper(Protocol):
    """Who holds the rooms and hears how storing them went."""

    def all_rooms(self) -> Iterable[Room]:
        """Every room there is now."""
        ...

    def note_committed(self, batch: TrialBatch) -> None:
        """This is stored for good."""
        ...

    def forget(self, room: Room) -> None:
        """The room's result is stored; the room is not needed any more."""
        ...

    def close_refused(self, trial_id: str) -> None:
        """What this trial did since the last commit cannot be stored."""
        ...

    def close_over(self, trial_id: str) -> None:
        """The trial had ended before: nothing more is stored of it."""
        ...


class JournalWriter:
    """The only writer of trials. A batch that failed is offered again, unchanged, before others.

    One that fails again and again while others can be stored is given up, and said so.
    A finished trial is reported to the desk only after everything of it was committed.
    Holding `between_commits` keeps it from starting a commit.
    `failing_since_s` is None while all is well, else the clock's time of the first failure.
    """

    def __init__(self, desk: TrialDesk, keeper: RoomKeeper, clock: Clock) -> None:
        self.failing_since_s: float | None = None
        self.commits = 0
        self.slowest_commit_s = 0.0
        self._desk = desk
        self._keeper = keeper
        self._clock = clock
        self._pending: tuple[TrialBatch, ...] = ()
        self._left_over: list[TrialBatch] = []
        self._finished: list[Room] = []
        self._failures = 0
        self.between_commits = asyncio.Lock()

    def keep(self, batch: TrialBatch | None) -> None:
        """Take over a room's batch; it is held until it is stored."""
        if batch is not None:
            self._left_over.append(batch)

    @property
    def owes(self) -> bool:
        """Whether something of a trial that has no room any more is not stored yet."""
        held = {room.setup.trial_id for room in self._keeper.all_rooms()}
        return any(b.trial_id not in held for b in (*self._pending, *self._left_over))

    async def run(self) -> None:
        """Write once a second until cancelled; wait longer after each failure, up to 10 s."""
        while True:
            wait_s = min(MAX_BACKOFF_S, PERIOD_S * 2**self._failures)
            await asyncio.sleep(wait_s)
            await self.flush()

    async def flush(self) -> bool:
        """Store everything there is now; False if the desk refused, and all is kept."""
        async with self.between_commits:
            started_s = self._clock.now_s()
            try:
                async with asyncio.timeout(COMMIT_WITHIN_S):
                    await self._commit()
                    await self._finish()
            except Exception:
                self._note_failure()
                return False
            self._failures = 0
            self.failing_since_s = None
            self.slowest_commit_s = max(self.slowest_commit_s, self._clock.now_s() - started_s)
            return True

    async def _commit(self) -> None:
        if self._pending:
            await self._commit_pending()
        for room in self._keeper.all_rooms():
            self.keep(room.take_batch())
            if room.result is not None and room not in self._finished:
                self._finished.append(room)
        self._pending = tuple(self._left_over)
        self._left_over = []
        if self._pending:
            await self._commit_pending()

    async def _commit_pending(self) -> None:
        try:
            over: Collection[str] = await self._desk.commit(self._pending)
        except Exception:
            if self._failures < ALONE_AFTER_FAILURES:
                raise
            over = await self._commit_singly()
        self.commits += 1
        committed, self._pending = self._pending, ()
        for batch in committed:
            if batch.trial_id not in over:
                self._keeper.note_committed(batch)
        for trial_id in over:
            self._drop(trial_id)
            self._keeper.close_over(trial_id)

    async def _commit_singly(self) -> set[str]:
        """After repeated failures: one trial that cannot be stored must not hold up the others."""
        refused: dict[str, Exception] = {}
        over: set[str] = set()
        for batch in self._pending:
            try:
                over |= set(await self._desk.commit((batch,)))
            except Exception as problem:
                refused[batch.trial_id] = problem
        if len(refused) == len({batch.trial_id for batch in self._pending}):
            raise next(iter(refused.values()))
        for trial_id, reason in refused.items():
            logger.error(
                "the trial %s cannot be stored and was given up", trial_id, exc_info=reason
            )
            self._drop(trial_id)
            self._keeper.close_refused(trial_id)
        self._pending = tuple(b for b in self._pending if b.trial_id not in refused)
        return over

    def _drop(self, trial_id: str) -> None:
        """Forget that this trial was to be finished."""
        self._finished = [room for room in self._finished if room.setup.trial_id != trial_id]

    async def _finish(self) -> None:
        while self._finished:
            room = self._finished[0]
            if room.result is not None:
                await self._desk.finish(room.setup.trial_id, room.result)
            self._finished.pop(0)
            room.finish_stored()
            self._keeper.forget(room)

    def _note_failure(self) -> None:
        if self.failing_since_s is None:
            self.failing_since_s = self._clock.now_s()
        self._failures = min(self._failures + 1, 6)
        logger.exception("trials could not be stored; everything is kept and tried again")
