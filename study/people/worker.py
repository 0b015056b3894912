"""The workers `believer` and `oracle` as a whole: tick by tick, or a trial in compiled code.

The oracle decides by the believer's rule, but on the truth: it knows at any moment where every
robot is and where it goes, judges distances exactly and has nothing to read.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from study.ar.display import DECISION_EVERY_TICKS
from study.ar.display_kernels import Shown, new_shown, refresh, show
from study.ar.elements import Display
from study.people.beliefs import Memory, new_memory
from study.people.believer import act
from study.people.habits import Habits
from study.people.walking import Legs, note_frame, walk
from study.warehouse.kernels import compiled_entry, kernel
from study.warehouse.state import RUNNING, Floor, Motion
from study.warehouse.step import step_world
from study.warehouse.world import World

BELIEVER = "believer"
ORACLE = "oracle"
THINK_TICKS = 6


@kernel
def decide_frame(
    floor: Floor,
    motion: Motion,
    memory: Memory,
    shown: Shown,
    walkers: npt.NDArray[np.void],
    ways: npt.NDArray[np.int16],
) -> None:
    """Set the walker's keys and yaw for the coming tick. `walkers`, `ways`: see `Legs`."""
    trial = motion.trial[0]
    if trial.tick % THINK_TICKS == 0:
        act(floor, motion, memory, shown, walkers[0])
    walk(
        trial, motion.cells, motion.robots, floor.fields, ways[0], ways[1], motion.queue,
        walkers[0], floor.hall[0].stride, floor.cosines,
    )  # fmt: skip


@kernel
def run_believer(
    floor: Floor,
    motion: Motion,
    memory: Memory,
    shown: Shown,
    walkers: npt.NDArray[np.void],
    ways: npt.NDArray[np.int16],
    record: npt.NDArray[np.int32],
) -> int:
    """Run the trial to its end with its display; return the ticks. `record`: see `note_frame`."""
    frames = np.zeros((1, 2), dtype=np.int32)
    trial = motion.trial[0]
    while trial.status == RUNNING:
        if trial.tick % DECISION_EVERY_TICKS == 0:
            refresh(floor, motion, shown)
        decide_frame(floor, motion, memory, shown, walkers, ways)
        note_frame(walkers[0], trial.tick, frames, record)
        step_world(floor, motion, frames, 1)
    return int(trial.tick)


class Believer:
    """The worker `believer` in one trial's world, or the `oracle` if it `knows` the truth."""

    def __init__(
        self, world: World, seed: int, habits: Habits | None = None, *, knows: bool = False
    ) -> None:
        habits = habits or Habits()
        values = habits.values_of("worker")
        self.legs = Legs(world.motion)
        self.shown = new_shown(world.layout, "none", None)
        self.memory = new_memory(world.layout, seed, values, knows=knows)
        self.memory.mind["onset"] = habits.balloon_belief == "onset"
        legs = (self.legs.walkers, self.legs.ways)
        self._own = (world.floor, world.motion, self.memory, self.shown, *legs)
        self._decide: Callable[..., None] | None = None

    def next_frame(self, display: Display) -> tuple[int, int]:
        """Return keys and yaw for the coming tick, given what is displayed."""
        show(self.shown, display)
        if self._decide is None:
            self._decide = compiled_entry(decide_frame, *self._own)
        self._decide(*self._own)
        return self.legs.frame

    def run(self, shown: Shown, record: npt.NDArray[np.int32]) -> int:
        """Run the trial to its end in compiled code; `shown` decides the display."""
        floor, motion, memory, _, walkers, ways = self._own
        return int(run_believer(floor, motion, memory, shown, walkers, ways, record))
