"""Trials without people or pictures: a compiled worker in a compiled world, from start to end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from study.errors import InvalidValue
from study.people.patrols import PATROLS, Patrol
from study.warehouse.layout import Layout
from study.warehouse.measures import TrialMeasures
from study.warehouse.world import World


@dataclass(frozen=True)
class HeadlessTrial:
    """One simulated trial. `inputs`: int32[ticks, 2], keys and yaw per tick, or None if unasked."""

    seed: int
    worker: str
    measures: TrialMeasures
    state_hash: bytes
    inputs: npt.NDArray[np.int32] | None


def check_worker(name: str) -> str:
    """Return the worker's name. Errors: InvalidValue naming those that exist."""
    if name not in PATROLS:
        raise InvalidValue(
            f"there is no worker “{name[:40]}”", next_step=f"Use one of: {', '.join(PATROLS)}."
        )
    return name


def simulate_trial(
    layout: Layout, seed: int, worker: str, *, keep_inputs: bool = False
) -> HeadlessTrial:
    """Run one trial to its end. The same layout, seed and worker give the same bits.

    Errors: InvalidValue for an unknown worker.
    """
    check_worker(worker)
    world = World(layout, seed)
    patrol = Patrol(worker, world.floor, world.motion, seed)
    most = int(world.floor.hall["cap_ticks"][0]) if keep_inputs else 0
    record = np.zeros((most, 2), dtype=np.int32)
    ticks = patrol.run(record)
    measures = world.measures()
    inputs = record[:ticks] if keep_inputs else None
    return HeadlessTrial(seed, worker, measures, world.state_hash(), inputs)


def simulate_many(layout: Layout, seeds: Sequence[int], worker: str) -> Iterator[HeadlessTrial]:
    """Run one trial per seed, one after the other."""
    for seed in seeds:
        yield simulate_trial(layout, seed, worker)
