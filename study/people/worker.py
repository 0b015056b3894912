"""The believer as a whole: its frames tick by tick, or a trial to its end in compiled code."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import numpy.typing as npt

from study.ar.display import DECISION_EVERY_TICKS
from study.ar.display_kernels import Shown, new_shown, refresh, show
from study.ar.elements import Display
from study.people.beliefs import BELIEF, MIND, NEVER, PLACE, Memory
from study.people.believer import THINKING, act
from study.people.looking import VIEW
from study.people.parameters import as_record, parameters_of
from study.people.walking import WALKER, turn_to_aim, walk
from study.warehouse.halls import TICK_HZ
from study.warehouse.kernels import kernel
from study.warehouse.state import RUNNING, Floor, Motion
from study.warehouse.step import step_world
from study.warehouse.world import World

BELIEVER = "believer"
THINK_TICKS = 6
BalloonBelief = Literal["onset", "always"]


@kernel
def decide_frame(
    floor: Floor,
    motion: Motion,
    memory: Memory,
    shown: Shown,
    walkers: npt.NDArray[np.void],
    ways: npt.NDArray[np.int16],
) -> None:
    """Set the walker's keys and yaw for the coming tick. `ways`: int16[2, C] of its own."""
    trial = motion.trial[0]
    walker = walkers[0]
    if trial.tick % THINK_TICKS == 0:
        act(floor, motion, memory, shown, walker)
    walk(
        trial, motion.cells, motion.robots, floor.fields, ways[0], ways[1], motion.queue, walker,
        floor.hall[0].stride,
    )  # fmt: skip
    if walker.keys != 0:
        turn_to_aim(trial, floor.cosines, walker)


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
    """Run the trial to its end with its display; `record` as in `patrols.run_patrol`."""
    frames = np.zeros((1, 2), dtype=np.int32)
    trial = motion.trial[0]
    while trial.status == RUNNING:
        if trial.tick % DECISION_EVERY_TICKS == 0:
            refresh(floor, motion, shown)
        decide_frame(floor, motion, memory, shown, walkers, ways)
        frames[0, 0] = walkers[0].keys
        frames[0, 1] = walkers[0].yaw
        if trial.tick < record.shape[0]:
            record[trial.tick, 0] = frames[0, 0]
            record[trial.tick, 1] = frames[0, 1]
        step_world(floor, motion, frames, 1)
    return int(trial.tick)


class Believer:
    """The worker `believer` in one trial's world."""

    def __init__(self, world: World, seed: int, balloon_belief: BalloonBelief = "onset") -> None:
        self.floor = world.floor
        self.motion = world.motion
        self.shown = new_shown(world.layout, "none", None)
        self.memory = _new_memory(world, seed, balloon_belief)
        self.walkers = np.zeros(1, dtype=WALKER)
        self.ways = np.zeros((2, world.motion.cells.size), dtype=np.int16)

    def next_frame(self, display: Display) -> tuple[int, int]:
        """Return keys and yaw for the coming tick, given what is displayed."""
        show(self.shown, display)
        decide_frame(self.floor, self.motion, self.memory, self.shown, self.walkers, self.ways)
        return int(self.walkers["keys"][0]), int(self.walkers["yaw"][0])

    def run(self, shown: Shown, record: npt.NDArray[np.int32]) -> int:
        """Run the trial to its end in compiled code; `shown` decides the display."""
        mine = (self.memory, shown, self.walkers, self.ways, record)
        return int(run_believer(self.floor, self.motion, *mine))


def _new_memory(world: World, seed: int, balloon_belief: BalloonBelief) -> Memory:
    """Return the memory before the first look: nothing known, all stations alike."""
    robots, stations = world.layout.spec.robots, len(world.layout.stations)
    values = dict(parameters_of("worker"))
    values["half_view_cosine"] = math.cos(math.radians(values["half_view_deg"]))
    values["hick_s"] = values["hick_s_per_bit"] * math.log2(stations + 1)
    memory = Memory(
        mind=np.zeros(1, dtype=MIND),
        beliefs=np.zeros(robots, dtype=BELIEF),
        places=np.zeros(stations, dtype=PLACE),
        views=np.zeros(1, dtype=VIEW),
        skill=as_record(values),
        draws=np.array([(seed * 2 + 1) & (2**64 - 1)], dtype=np.uint64),
        sights=np.zeros(robots, dtype=np.uint8),
    )
    memory.mind["phase"] = THINKING
    memory.mind["onset"] = balloon_belief == "onset"
    memory.beliefs["first"] = memory.beliefs["second"] = -1
    memory.beliefs["noticed"] = NEVER
    memory.places["visited"] = -int(values["start_s"] * TICK_HZ)
    memory.places["noticed"] = NEVER
    memory.places["lit"] = -1
    memory.places["hits"] = 2.0
    memory.places["tries"] = 3.0
    memory.views["sight_m"] = values["sight_m"]
    return memory
