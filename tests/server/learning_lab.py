"""A learning run on a database, with rows and trials as the live loop hands them in."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import func, select

from server.desks.learning import RunRequest, StoredLearningDesk
from server.desks.trials import StoredTrialDesk
from server.live.learning.ports import OpenRun
from server.live.learning.rows import LearningRows
from server.live.ports import TrialBatch, TrialSetup
from server.store.engine import Database
from study.learning.agreement import Setting
from study.learning.dataset import Pair
from study.learning.settings import LearningSettings
from study.records.events import JournalEvent
from study.records.journal import JournalChunk
from study.warehouse.halls import PRESETS

SETTINGS = LearningSettings(iterations=3, beta="exponential(0.5)", seed=2**53)
START = {"j": 1, "streams": [2**64 - 1, 0], "boxes": {"masks": [7, 1], "edited": [-1, 40]}}


def request(worker: Any = "person") -> RunRequest:
    return RunRequest("small", SETTINGS, worker)


def pair(number: int) -> Pair:
    station = number % 2
    return Pair(
        iteration=number // 25,
        trial=0,
        trial_seed=2**62 + 1,
        tick=120,
        domain=station,
        agent=number % 3,
        state=number % 18,
        box=station,
        proposal=1,
        drawn=1,
        label=station,
        edit_ticks=number - 1,
        by_expert=number % 2,
    )


def rating(agent: int) -> Setting:
    return Setting(0, 120, "ben", agent, 7, 3, 5)


def rows(run_id: str, first: int, last: int, **changes: Any) -> LearningRows:
    """Pairs with these numbers, as a batch carries them."""
    given = LearningRows(
        run_id=run_id,
        pairs=tuple((number, pair(number)) for number in range(first, last)),
        versions=(),
        ratings=(),
        iteration=last // 25,
        finished=False,
    )
    return replace(given, **changes)


def batch(trial_id: str, first_tick: int, learning: LearningRows | None) -> TrialBatch:
    chunk = JournalChunk(first_tick, 2, b"\x00\x00", (), 7)
    data = {"expert": "ann", "client": "0123456789abcdef"}
    event = JournalEvent(first_tick, first_tick, "expert_joined", datetime.now(UTC), data)
    return TrialBatch(trial_id, chunk, (event,), first_tick + 1, "running", learning)


class Lab:
    """A database with its two desks and one run."""

    def __init__(self, database: Database) -> None:
        self.database = database
        self.desk = StoredLearningDesk(database)
        self.trials = StoredTrialDesk(database)
        self.run_id = ""
        self.token: str | None = None

    async def start(self, worker: str = "person") -> Lab:
        self.run_id, self.token = await self.desk.create_run(request(worker), "ann")
        return self

    async def begin(self, number: int, trial_id: str = "") -> TrialSetup:
        setup = TrialSetup(
            trial_id=trial_id or f"{number:032x}",
            kind="learning",
            scale="small",
            spec=PRESETS["small"],
            seed=2**62 + number,
            condition="learning",
            policy=None,
            label="Learning",
            mode="learning",
            on_disconnect="continue",
            number=number,
        )
        await self.desk.begin_trial(self.run_id, number, setup, START)
        return setup

    async def read(self) -> OpenRun:
        return await self.desk.open_run(self.run_id)

    async def count(self, table: type) -> int:
        async with self.database.reading() as session:
            return await session.scalar(select(func.count()).select_from(table)) or 0
