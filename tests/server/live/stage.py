"""A stage for rooms without sockets, database or waiting: a clock to turn and a sink to read."""

import asyncio
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from server.live import wire
from server.live.opening import open_room
from server.live.ports import OpenTrial, TrialBatch, TrialResult, TrialSetup
from server.live.room import Room
from study.errors import UnknownToken
from study.learning.policy import initial_policy
from study.records.events import JournalEvent
from study.records.journal import JournalChunk
from study.warehouse.layout import PRESETS
from study.warehouse.world import World

PERIOD_S = 1 / 30
SETUP = TrialSetup(
    trial_id="t-1",
    kind="practice",
    scale="practice",
    spec=PRESETS["practice"],
    seed=5,
    condition="varil",
    policy=initial_policy(),
    label="Practice",
    mode="live",
)


class FakeClock:
    """Time that passes only when told to."""

    def __init__(self) -> None:
        self.at_s = 1000.0

    def now_s(self) -> float:
        return self.at_s

    def utc(self) -> datetime:
        return datetime(2026, 1, 1, tzinfo=UTC) + timedelta(seconds=self.at_s)

    def pass_s(self, seconds: float) -> None:
        self.at_s += seconds


@dataclass
class Listener:
    """A sink that keeps what it is told."""

    texts: list[dict[str, Any]] = field(default_factory=list)
    controls: list[bytes] = field(default_factory=list)
    snapshots: list[bytes] = field(default_factory=list)
    closed: tuple[int, str] | None = None
    is_finished: bool = False

    def send_text(self, text: str) -> None:
        self.texts.append(json.loads(text))

    def send_control(self, data: bytes) -> None:
        self.controls.append(data)

    def send_snapshot(self, data: bytes) -> None:
        self.snapshots.append(data)

    def send_finished(self) -> None:
        self.is_finished = True

    def close(self, code: int, reason: str) -> None:
        self.closed = (int(code), reason)

    def phases(self) -> list[tuple[str, str]]:
        return [(t["phase"], t["reason"]) for t in self.texts if t["type"] == "phase"]


class MemoryDesk:
    """A TrialDesk in memory that can be told to fail."""

    def __init__(self, *setups: TrialSetup) -> None:
        self.setups = {f"token-{setup.trial_id}": setup for setup in setups}
        self.chunks: dict[str, list[JournalChunk]] = {}
        self.events: dict[str, list[JournalEvent]] = {}
        self.results: dict[str, TrialResult] = {}
        self.failures = 0
        self.opened = 0
        self.erased: set[str] = set()
        self.over: set[str] = set()

    async def open_trial(self, token: str) -> OpenTrial:
        self.opened += 1
        await asyncio.sleep(0)
        if token not in self.setups:
            raise UnknownToken
        setup = self.setups[token]
        chunks = tuple(self.chunks.get(setup.trial_id, ()))
        return OpenTrial(setup, chunks, tuple(self.events.get(setup.trial_id, ())))

    async def commit(self, batches: Sequence[TrialBatch]) -> set[str]:
        await asyncio.sleep(0)
        if self.failures:
            self.failures -= 1
            raise ConnectionError("the database is away")
        if self.erased & {batch.trial_id for batch in batches}:
            raise LookupError("no such trial")
        for batch in batches:
            if batch.trial_id in self.over:
                continue
            if batch.chunk is not None:
                self.chunks.setdefault(batch.trial_id, []).append(batch.chunk)
            self.events.setdefault(batch.trial_id, []).extend(batch.events)
        return self.over & {batch.trial_id for batch in batches}

    async def finish(self, trial_id: str, result: TrialResult) -> None:
        assert self.chunks.get(trial_id) or result.ticks == 0, "committed before it is finished"
        self.results[trial_id] = result

    def kinds(self, trial_id: str = "t-1") -> list[str]:
        return [event.kind for event in self.events.get(trial_id, ())]


Walker = Callable[[World], tuple[int, int]]


def stand(world: World) -> tuple[int, int]:
    """No key held, the view as it is."""
    return 0, world.human_yaw


class Stage:
    """One room with its participant's hands: `play` walks, `run` only lets time pass."""

    def __init__(self, room: Room, clock: FakeClock) -> None:
        self.room = room
        self.clock = clock
        self.seq = 0

    @classmethod
    def open(
        cls, clock: FakeClock | None = None, trial: OpenTrial | None = None, **changes: Any
    ) -> "Stage":
        clock = clock or FakeClock()
        trial = trial or OpenTrial(replace(SETUP, **changes))
        stage = cls(asyncio.run(open_room(trial, clock)), clock)
        stage.seq = trial.journal[-1].last_seq if trial.journal else 0
        return stage

    def join(self, is_ready: bool = True) -> Listener:
        listener = Listener()
        self.room.join(listener)
        if is_ready:
            self.room.take_ready()
            self.run(wire.COUNTDOWN_S + 0.1)
        return listener

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / PERIOD_S)):
            self.clock.pass_s(PERIOD_S)
            self.room.advance()

    def send(self, *frames: tuple[int, int]) -> None:
        self.room.take_input(wire.Input(self.seq + 1, frames))
        self.seq += len(frames)

    def play(self, seconds: float, walker: Walker = stand) -> None:
        for _ in range(round(seconds / PERIOD_S)):
            if self.room.phase == "running":
                self.send(walker(self.room.world))
            self.clock.pass_s(PERIOD_S)
            self.room.advance()

    def play_to_end(self, walker: Walker, limit_s: float = 400.0) -> None:
        waited_s = 0.0
        while self.room.result is None:
            self.play(1.0, walker)
            waited_s += 1.0
            assert waited_s < limit_s, "the trial does not end"


def step_towards(world: World, goal: tuple[int, int]) -> tuple[int, int]:
    """The input frame that walks the shortest lattice path to a free cell."""
    field = world.layout.distance_field(goal)
    a, b = int(world.human_x_m // 0.6), int((world.human_y_m - 0.6) // 0.6)
    near = [(a, b), (a + 1, b), (a - 1, b), (a, b + 1), (a, b - 1)]
    height, width = field.shape
    inside = [(p, q) for p, q in near if 0 <= p < width and 0 <= q < height and field[q, p] >= 0]
    x, y = world.layout.cell_center_m(*min(inside, key=lambda cell: field[cell[1], cell[0]]))
    dx, dy = x - world.human_x_m, y - world.human_y_m
    if np.hypot(dx, dy) < 0.03:
        return 0, world.human_yaw
    return 1, round(np.arctan2(dy, dx) / (2 * np.pi) * 65536) & 65535


def serve_stations(world: World) -> tuple[int, int]:
    """Walk to the station of the first robot that waits; otherwise back, out of the way."""
    waiting = np.flatnonzero(world.robot_state == 3)
    if not len(waiting):
        x, y = world.layout.human_start_m
        return step_towards(world, (int(x // 0.6), int((y - 0.6) // 0.6)))
    x, y = world.robot_x_m[waiting[0]], world.robot_y_m[waiting[0]]
    top = world.layout.height_cells - 1
    return step_towards(world, (int(x // 0.6), min(max(int((y - 0.6) // 0.6), 0), top)))
