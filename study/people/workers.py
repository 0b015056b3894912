"""All simulated workers by name."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from study.ar.display_kernels import Shown
from study.ar.elements import Display
from study.errors import InvalidValue
from study.people.habits import Habits
from study.people.patrols import PATROLS, Patrol
from study.people.worker import BELIEVER, ORACLE, Believer
from study.warehouse.world import World

WORKERS = (*PATROLS, BELIEVER, ORACLE)


class Worker(Protocol):
    """Somebody who walks, and may look at the display."""

    def next_frame(self, display: Display) -> tuple[int, int]:
        """Return keys and yaw for the coming tick."""
        ...

    def run(self, shown: Shown, record: npt.NDArray[np.int32]) -> int:
        """Run the trial to its end in compiled code, `shown` deciding the display; return the
        ticks. `record`: int32[most ticks, 2] takes each tick's keys and yaw, int32[0, 2] none."""
        ...


class UnseeingWorker:
    """A worker who knows the world itself and looks at no display."""

    def __init__(self, name: str, world: World, seed: int) -> None:
        self._patrol = Patrol(name, world.floor, world.motion, seed)

    def next_frame(self, display: Display) -> tuple[int, int]:
        """Return keys and yaw, whatever is displayed."""
        del display
        return self._patrol.next_frame()

    def run(self, shown: Shown, record: npt.NDArray[np.int32]) -> int:
        """Run the trial to its end, whatever is displayed."""
        del shown
        return self._patrol.run(record)


def check_worker(name: str) -> str:
    """Return the worker's name. Errors: InvalidValue naming those that exist."""
    if name not in WORKERS:
        raise InvalidValue(
            f"there is no worker “{name[:40]}”", next_step=f"Use one of: {', '.join(WORKERS)}."
        )
    return name


def new_worker(name: str, world: World, seed: int, habits: Habits | None = None) -> Worker:
    """Return the worker of this name for one trial. Errors: InvalidValue for an unknown one."""
    if check_worker(name) in PATROLS:
        return UnseeingWorker(name, world, seed)
    return Believer(world, seed, habits, knows=name == ORACLE)
