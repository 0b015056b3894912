"""Where the person was in a stored trial: its world, re-simulated from its journal."""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from server.store.journals import read_journal
from server.store.trials import TrialRecord, read_trial
from study.errors import JournalError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from study.records.journal import JournalChunk
    from study.warehouse.world import World

EVERY_TICKS = 6
YAW_RAD = 2 * math.pi / 65536


@dataclass(frozen=True)
class Telemetry:
    """Reads trials in one transaction."""

    session: Any

    async def read(self, trial_id: str) -> list[dict[str, Any]] | str:
        """Rows of the trial five times a second, or why it could not be re-simulated."""
        trial = await read_trial(self.session, trial_id)
        journal, _ = await read_journal(self.session, trial_id)
        if not journal:
            return "no inputs of it are stored"
        if trial.state_hash is not None and journal[-1].last_tick != trial.ticks:
            return f"its stored inputs end at tick {journal[-1].last_tick} of {trial.ticks}"
        try:
            return await asyncio.to_thread(trace_person, trial, journal)
        except JournalError as error:
            return error.what


def trace_person(trial: TrialRecord, journal: Sequence[JournalChunk]) -> list[dict[str, Any]]:
    """Rows of telemetry; raises JournalError where the stored hashes are not met."""
    from study.records.journal import replay

    world = build_world(trial)
    start = _row(trial.id, world)
    steps = replay(world, journal)
    return [start, *(_row(trial.id, w) for w in steps if w.tick % EVERY_TICKS == 0)]


def build_world(trial: TrialRecord) -> World:
    """The world of a stored trial before its first tick."""
    from study.warehouse.halls import HallSpec
    from study.warehouse.layout import build_layout
    from study.warehouse.world import World

    return World(build_layout(HallSpec.from_json(trial.config["hall"])), trial.seed)


def _row(trial_id: str, world: World) -> dict[str, Any]:
    return {
        "trial_id": trial_id,
        "tick": world.tick,
        "time_s": round(world.tick / 30, 3),
        "x_m": round(world.human_x_m, 4),
        "y_m": round(world.human_y_m, 4),
        "yaw_rad": round(world.human_yaw * YAW_RAD, 5),
    }
