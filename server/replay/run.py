"""The body of `varil replay`: a stored trial re-simulated, checked, and seen with another policy.

What a policy would have shown is shown to nobody: the person's inputs stay those of the trial.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from server.export.telemetry import EVERY_TICKS, build_world
from server.kernel_cache import open_kernel_cache
from server.replay.trace import TRACE_HEADER, trace_rows
from server.settings import Settings
from server.store.engine import Database
from server.store.journals import read_journal
from server.store.schema import check_schema
from server.store.trials import TrialRecord, read_trial
from study.ar.conditions import Varil
from study.ar.display import DisplayClock
from study.ar.elements import Display
from study.ar.shares import DisplayShares
from study.ar.thresholds import Thresholds
from study.errors import WrongMoment
from study.learning.policy import Policy
from study.records.events import JournalEvent
from study.records.journal import JournalChunk, replay
from study.warehouse.world import World


class NothingPlayed(WrongMoment):
    """The trial was opened, but its world never moved."""

    def __init__(self, trial_id: str) -> None:
        self.trial_id = trial_id
        super().__init__(
            f"the trial {trial_id} has no stored inputs",
            next_step="Choose one whose ticks in trials.csv are above 0.",
        )


@dataclass(frozen=True)
class StoredTrial:
    """Everything that is stored of a trial."""

    record: TrialRecord
    journal: tuple[JournalChunk, ...]
    events: tuple[JournalEvent, ...]


async def load_trial(settings: Settings, trial_id: str) -> StoredTrial:
    """Read a trial; raises `UnknownTrial` or `NothingPlayed`."""
    database = Database(settings.database)
    try:
        await check_schema(database)
        async with database.reading() as session:
            record = await read_trial(session, trial_id)
            journal, events = await read_journal(session, trial_id)
    finally:
        await database.close()
    if not journal:
        raise NothingPlayed(trial_id)
    return StoredTrial(record, journal, events)


def replay_trial(trial: StoredTrial, policy: Policy | None, trace: Path | None) -> dict[str, Any]:
    """Re-simulate a trial; the summary tells hashes checked and, with a policy, its display.

    Raises `JournalError` for a damaged journal and `PolicyError` for a policy with other borders
    of the states than the trial's.
    """
    if policy is not None:
        policy.require_thresholds(Thresholds.from_json(trial.record.config["thresholds"]))
    open_kernel_cache()
    run = _Run(trial, policy)
    if trace is None:
        for _ in run.steps():
            pass
        return run.summary()
    with trace.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(TRACE_HEADER)
        for world in run.steps():
            if world.tick % EVERY_TICKS == 0:
                writer.writerows(trace_rows(world, run.shown, run.wished))
    return run.summary() | {"trace": str(trace)}


class _Run:
    """One pass over a trial. `shown` is what was displayed, `wished` what the policy would show."""

    def __init__(self, trial: StoredTrial, policy: Policy | None) -> None:
        self._trial = trial
        self._policy = policy
        self._world = build_world(trial.record)
        robots, stations = len(self._world.robot_x_m), len(self._world.layout.stations)
        self.shown = Display.nothing(robots, stations)
        self.wished: Display | None = None
        self._clock = DisplayClock(Varil(policy), robots, stations) if policy else None
        self._shares = DisplayShares(robots, stations)
        self._checked = 0
        self._mismatches: list[int] = []

    def steps(self) -> Iterator[World]:
        """The world at its start and after every tick."""
        changes = list(_displays(self._trial.events))[::-1]
        if self._clock is not None:
            self.wished = self._clock.start(self._world)
        self._follow(changes, 0)
        yield self._world
        for world in replay(self._world, self._trial.journal, self._note_hash):
            self._shares.add(self.shown, self.wished)
            tick = world.tick
            if self._clock is not None:
                self.wished = self._clock.update(world) or self.wished
            self._follow(changes, tick)
            yield world
        self._check_end()

    def summary(self) -> dict[str, Any]:
        """What was found."""
        first = {"first_mismatch_tick": self._mismatches[0]} if self._mismatches else {}
        found: dict[str, Any] = {
            "trial": self._trial.record.id,
            "ticks": self._world.tick,
            "hashes_checked": self._checked,
            "mismatches": len(self._mismatches),
            **first,
            "condition": self._trial.record.condition,
            "status": self._trial.record.status,
            "ran_policy_sha256": self._trial.record.policy_sha256,
        }
        if self._policy is not None:
            found["policy_sha256"] = self._policy.sha256
        return found | self._shares.summary()

    def _follow(self, changes: list[tuple[int, Display]], tick: int) -> None:
        """Show what the trial's events say was shown from this tick on."""
        while changes and changes[-1][0] <= tick:
            self.shown = changes.pop()[1]

    def _check_end(self) -> None:
        """The world of a trial that ended is where its result says that it ended."""
        ended = self._trial.record
        if ended.state_hash is not None:
            world = self._world
            is_there = (world.tick, world.state_hash()) == (ended.ticks, ended.state_hash)
            self._note_hash(world.tick, is_there)

    def _note_hash(self, tick: int, equal: bool) -> None:
        self._checked += 1
        if not equal:
            self._mismatches.append(tick)


def _displays(events: Sequence[JournalEvent]) -> Iterator[tuple[int, Display]]:
    for event in events:
        if event.kind == "display_decided":
            robots = bytes.fromhex(str(event.data["robots"]))
            stations = bytes(map(int, str(event.data["stations"])))
            yield event.tick, Display(robots, stations, int(event.data["overlays"]))
