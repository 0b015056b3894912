"""Learning runs without sockets, database, processes or waiting: a clock to turn and pages to read.

`Lab.crash` drops everything that is held in memory; what was committed stays on the desk.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from server.live.hall import Hall
from server.live.learning import wire
from server.live.learning.experts import Seat
from server.live.learning.ports import OpenRun, RunSetup
from server.live.learning.rows import RunVersion
from server.live.learning.run import LearningRun
from server.live.learning.runs import LearningRuns
from server.live.ports import OpenTrial, TrialBatch, TrialResult, TrialSetup
from study.errors import UnknownRun, UnknownToken, WrongMoment
from study.learning.agreement import Setting
from study.learning.dataset import Pair
from study.learning.policy import read_policy
from study.learning.settings import LearningSettings
from study.learning.training import Tables, TrainingOrder
from study.records.events import JournalEvent, check_event
from study.records.journal import JournalChunk
from study.warehouse.layout import PRESETS
from tests.server.live.stage import PERIOD_S, FakeClock, Listener

RUN = "0" * 32
ANNA, BEN = "a" * 16, "b" * 16
NAMES = {ANNA: "anna", BEN: "ben"}
SETTINGS = LearningSettings(iterations=12, beta="exponential(0.8)", classifier="majority", seed=4)
HALL = replace(PRESETS["small"], boxes_per_robot=1)
SETUP = RunSetup(RUN, SETTINGS, "small", HALL, "simulated", "anna")


class MemoryLearningDesk:
    """One run's LearningDesk and its trials' TrialDesk; everything goes through JSON once."""

    def __init__(self, setup: RunSetup = SETUP) -> None:
        self.setup = setup
        self.status: Any = "open"
        self.versions: dict[int, str] = {}
        self.pairs: dict[int, Pair] = {}
        self.ratings: dict[int, Setting] = {}
        self.iteration = 0
        self.trials: list[tuple[TrialSetup, str]] = []
        self.chunks: dict[str, list[JournalChunk]] = {}
        self.events: dict[str, list[JournalEvent]] = {}
        self.results: dict[str, TrialResult] = {}
        self.failures = 0

    # ---- LearningDesk -----------------------------------------------------------------------

    async def open_run(self, run_id: str) -> OpenRun:
        await asyncio.sleep(0)
        if run_id != self.setup.run_id:
            raise UnknownRun(run_id)
        assert sorted(self.pairs) == list(range(len(self.pairs)))
        trial, start = None, None
        if self.trials:
            setup, text = self.trials[-1]
            start = json.loads(text)
            journal = tuple(self.chunks.get(setup.trial_id, ()))
            trial = OpenTrial(setup, journal, tuple(self.events.get(setup.trial_id, ())))
        return OpenRun(
            setup=self.setup,
            status=self.status,
            versions=tuple(RunVersion(n, read_policy(t)) for n, t in sorted(self.versions.items())),
            pairs=tuple(self.pairs[n] for n in sorted(self.pairs)),
            ratings=tuple(self.ratings[n] for n in sorted(self.ratings)),
            trials=len(self.trials),
            trial=trial,
            start=start,
            trial_ended=trial is not None and trial.setup.trial_id in self.results,
        )

    async def find_worker(self, token: str) -> str:
        if token != "token":
            raise UnknownToken
        return self.setup.run_id

    async def begin_trial(
        self, run_id: str, number: int, setup: TrialSetup, start: Mapping[str, Any]
    ) -> None:
        await self._answer()
        if self.status != "open":
            raise WrongMoment("over")
        if any(known.trial_id == setup.trial_id for known, _ in self.trials):
            return
        assert number == len(self.trials)
        assert run_id == self.setup.run_id
        self.trials.append((setup, json.dumps(start)))

    async def end_run(self, run_id: str, status: str) -> None:
        self.status = status if self.status == "open" else self.status

    # ---- TrialDesk --------------------------------------------------------------------------

    async def open_trial(self, token: str) -> OpenTrial:
        raise UnknownToken

    async def commit(self, batches: Sequence[TrialBatch]) -> Collection[str]:
        await self._answer()
        if self.status == "stopped":
            return {batch.trial_id for batch in batches}
        for batch in batches:
            if batch.chunk is not None:
                self.chunks.setdefault(batch.trial_id, []).append(batch.chunk)
            for event in batch.events:
                check_event(event.kind, event.data)
            self.events.setdefault(batch.trial_id, []).extend(batch.events)
            rows = batch.learning
            if rows is not None:
                self.pairs |= dict(rows.pairs)
                self.versions |= {v.iteration: v.policy.to_json() for v in rows.versions}
                self.ratings |= dict(rows.ratings)
                self.iteration = rows.iteration
                self.status = "finished" if rows.finished else self.status
        return set()

    async def finish(self, trial_id: str, result: TrialResult) -> None:
        self.results[trial_id] = result

    async def _answer(self) -> None:
        await asyncio.sleep(0)
        if self.failures:
            self.failures -= 1
            raise ConnectionError("the database is away")

    def kinds(self, number: int = -1) -> list[str]:
        """The kinds of a trial's events that are no world's and no display's."""
        events = self.events.get(self.trials[number][0].trial_id, ())
        return [event.kind for event in events if event.kind.startswith(("expert", "lead"))]


class ReadyTrainer:
    """Trains at once: for each state the label met most often. `gate` holds it up."""

    def __init__(self) -> None:
        self.orders: list[int] = []
        self.gate = asyncio.Event()
        self.gate.set()

    def warm_up(self) -> None:
        pass

    async def train(self, order: TrainingOrder) -> Tables:
        self.orders.append(order.iteration)
        await self.gate.wait()
        robots, stations = (
            tuple(np.where(c.any(axis=1), c.argmax(axis=1), c.shape[1] - 1).tolist())
            for c in order.counts
        )
        return robots, stations

    async def stop(self) -> None:
        pass


async def be_ready() -> None:
    """The kernels are there already."""


Script = Callable[["Lab"], None]


class Lab:
    """A server's live part with one run, driven second by second."""

    def __init__(self, desk: MemoryLearningDesk | None = None) -> None:
        self.desk = desk or MemoryLearningDesk()
        self.clock = FakeClock()
        self.trainer = ReadyTrainer()
        self.pages: dict[str, Listener] = {}
        self.seats: dict[str, Seat] = {}
        self._build()

    def _build(self) -> None:
        self.hall = Hall(self.desk, be_ready, self.clock)
        self.runs = LearningRuns(self.desk, self.hall, self.trainer)

    def crash(self) -> None:
        """Everything in memory is gone."""
        for run in tuple(self.runs.held.values()):
            run.close()
        self.pages, self.seats = {}, {}
        self._build()

    @property
    def run(self) -> LearningRun:
        return self.runs.held[RUN]

    @property
    def room(self) -> Any:
        room = self.run.room
        assert room is not None
        return room

    async def join(self, client: str = ANNA) -> Listener:
        run = await self.runs.open(RUN)
        page = self.pages[client] = Listener()
        self.seats[client] = run.join(page, NAMES[client], client)
        return page

    def leave(self, client: str = ANNA) -> None:
        self.run.leave(self.seats.pop(client))

    def edit(self, seq: int, *changes: tuple[int, int, int], client: str = ANNA) -> None:
        up, tick = self.room.session.up, self.room.world.tick
        self.run.edit(self.seats[client], wire.Edit(seq, up.trial, tick, changes))

    async def play(self, seconds: int, script: Script | None = None, *, store: bool = True) -> None:
        """Seconds of thirty periods; then trainings that are ready come back, and all is stored.

        `script` acts after each period.
        """
        for _ in range(seconds):
            for _ in range(30):
                self.clock.pass_s(PERIOD_S)
                for room in self.hall.all_rooms():
                    room.advance()
                if script is not None and RUN in self.runs.held:
                    script(self)
            await settle()
            if store:
                await self.hall.writer.flush()
                await settle()

    async def start(self) -> Listener:
        """Anna joins, and the countdown passes."""
        page = await self.join()
        await self.play(4)
        return page

    def texts(self, kind: str, client: str = ANNA) -> list[dict[str, Any]]:
        return [text for text in self.pages[client].texts if text["type"] == kind]


async def settle() -> None:
    """Let tasks that wait for nothing but one another come to their end."""
    for _ in range(12):
        await asyncio.sleep(0)


def for_person(**changes: Any) -> MemoryLearningDesk:
    """A desk whose run has a person as its worker."""
    return MemoryLearningDesk(replace(SETUP, worker="person", **changes))


def short_run(iterations: int) -> MemoryLearningDesk:
    """A desk whose run has so many iterations."""
    return MemoryLearningDesk(replace(SETUP, settings=replace(SETTINGS, iterations=iterations)))
