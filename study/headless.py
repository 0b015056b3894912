"""Trials without people or pictures: a compiled worker in a compiled world, from start to end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from study.ar.conditions import PolicyTables
from study.ar.display_kernels import new_shown
from study.people.habits import Habits
from study.people.workers import WORKERS, check_worker, new_worker
from study.warehouse.layout import Layout
from study.warehouse.measures import TrialMeasures
from study.warehouse.world import World

__all__ = ["WORKERS", "HeadlessTrial", "check_worker", "simulate_many", "simulate_trial"]


@dataclass(frozen=True)
class HeadlessTrial:
    """One simulated trial. `inputs`: int32[ticks, 2], keys and yaw per tick, or None if unasked."""

    seed: int
    worker: str
    measures: TrialMeasures
    state_hash: bytes
    inputs: npt.NDArray[np.int32] | None


def simulate_trial(
    layout: Layout,
    seed: int,
    worker: str,
    *,
    condition: str = "none",
    policy: PolicyTables | None = None,
    habits: Habits | None = None,
    keep_inputs: bool = False,
) -> HeadlessTrial:
    """Run one trial to its end. The same arguments give the same bits.

    Only the believer looks at the display that `condition` shows; `varil` needs its policy.
    `habits`: of the believer or the oracle, the defaults where there are none.
    Errors: InvalidValue for an unknown worker, UnknownCondition.
    """
    check_worker(worker)
    world = World(layout, seed)
    most = int(world.floor.hall["cap_ticks"][0]) if keep_inputs else 0
    record = np.zeros((most, 2), dtype=np.int32)
    walker = new_worker(worker, world, seed, habits)
    ticks = walker.run(new_shown(layout, condition, policy), record)
    measures = world.measures()
    inputs = record[:ticks] if keep_inputs else None
    return HeadlessTrial(seed, worker, measures, world.state_hash(), inputs)


def simulate_many(
    layout: Layout,
    seeds: Sequence[int],
    worker: str,
    condition: str = "none",
    policy: PolicyTables | None = None,
    habits: Habits | None = None,
) -> Iterator[HeadlessTrial]:
    """Run one trial per seed, one after the other."""
    for seed in seeds:
        yield simulate_trial(
            layout, seed, worker, condition=condition, policy=policy, habits=habits
        )
