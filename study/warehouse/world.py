"""One trial's world: a hall, its robots and the human, advanced tick by tick.

The same layout, seed and inputs give the same bits at every tick, in any process: see `state_hash`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
import numpy.typing as npt

from study.warehouse.halls import PRESETS, TICK_HZ
from study.warehouse.kernels import compiled_entry
from study.warehouse.kinematics import KEY_W
from study.warehouse.layout import Layout, build_layout
from study.warehouse.life import EVENT_KINDS
from study.warehouse.measures import TrialMeasures, measure_trial
from study.warehouse.outlines import HUMAN_NUMBERS, ROBOT_NUMBERS, outline_path, outline_world
from study.warehouse.state import (
    FORWARD,
    STATUSES,
    Motion,
    RobotState,
    build_floor,
    hash_state,
    new_motion,
)
from study.warehouse.step import step_world
from study.warehouse.tasks import TaskSource

__all__ = ["RobotState", "World", "WorldEvent", "compile_kernels"]

MOST_FRAMES = 3
Status = Literal["running", "completed", "timed_out"]

EVENT_DATA: Mapping[str, tuple[str, ...]] = {
    "leg_started": ("shelf", "box"),
    "box_picked": ("colour", "station"),
    "wait_started": ("station",),
    "unload_started": ("station",),
    "box_delivered": ("colour", "station"),
    "returning_started": (),
    "home_reached": (),
    "trial_completed": (),
    "trial_timed_out": (),
}
"""What each kind of event carries in its data."""


@dataclass(frozen=True)
class WorldEvent:
    """Something that happened in a tick; `robot` is None where it concerns the whole trial."""

    tick: int
    kind: str
    robot: int | None
    data: Mapping[str, int | float | str]


class World:
    """A trial's world. Arrays per robot are views of the state: read them, never write.

    They stay valid and current over all steps.
    """

    def __init__(self, layout: Layout, seed: int, tasks: TaskSource | None = None) -> None:
        self.layout = layout
        self.seed = seed
        self.floor = build_floor(layout)
        self.motion: Motion = new_motion(layout, seed, tasks)
        self._frames = np.zeros((MOST_FRAMES, 2), dtype=np.int32)
        self._step: Callable[..., int] | None = None
        self._trial = self.motion.trial
        robots = self.motion.robots
        self._numbers = np.zeros(HUMAN_NUMBERS + ROBOT_NUMBERS * len(robots), dtype=np.int64)
        self._corners = np.zeros((self.motion.plans.shape[1], 2), dtype=np.int16)
        self.robot_x_m: npt.NDArray[np.float64] = robots["x"]
        self.robot_y_m: npt.NDArray[np.float64] = robots["y"]
        self.robot_heading: npt.NDArray[np.uint16] = robots["heading"]
        self.robot_state: npt.NDArray[np.int8] = robots["state"]
        self.robot_carrying: npt.NDArray[np.int8] = robots["carrying"]
        self.robot_station: npt.NDArray[np.int8] = robots["station"]
        self.robot_remaining: npt.NDArray[np.int32] = robots["remaining"]
        self.plan_version: npt.NDArray[np.int64] = robots["plan_version"]

    def step(self, frames: Sequence[tuple[int, int]]) -> list[WorldEvent]:
        """Advance by one tick (1/30 s) with 0 to 3 frames (keys, yaw) of the human's motion.

        Returns the tick's events in order. A world that has ended stays as it is. Errors:
        ValueError for more than 3 frames.
        """
        count = len(frames)
        if count > MOST_FRAMES:
            raise ValueError(f"a tick takes at most {MOST_FRAMES} input frames, not {count}")
        for n, (keys, yaw) in enumerate(frames):
            self._frames[n, 0] = keys & 15
            self._frames[n, 1] = yaw & 65535
        if self._step is None:
            self._step = compiled_entry(step_world, self.floor, self.motion, self._frames, count)
        if self._step(self.floor, self.motion, self._frames, count):
            return self._read_events()
        return []

    def _read_events(self) -> list[WorldEvent]:
        tick = self.tick
        events = []
        for kind, robot, *data in self.motion.events[: int(self._trial["events"][0])].tolist():
            name = EVENT_KINDS[kind]
            record = dict(zip(EVENT_DATA[name], data, strict=False))
            events.append(WorldEvent(tick, name, None if robot < 0 else robot, record))
        return events

    @property
    def tick(self) -> int:
        """How many ticks have passed."""
        return int(self._trial["tick"][0])

    @property
    def status(self) -> Status:
        """Running until every robot is home (completed) or the cap is reached (timed_out)."""
        return cast(Status, STATUSES[int(self._trial["status"][0])])

    @property
    def human_x_m(self) -> float:
        """The human's x in metres."""
        return float(self._trial["x"][0])

    @property
    def human_y_m(self) -> float:
        """The human's y in metres."""
        return float(self._trial["y"][0])

    @property
    def human_yaw(self) -> int:
        """The human's view, 65536ths of a turn anticlockwise from +x."""
        return int(self._trial["yaw"][0])

    @property
    def human_stopped(self) -> bool:
        """Whether a robot was in the human's way in the last tick."""
        return bool(self._trial["contact"][0])

    @property
    def boxes_delivered(self) -> int:
        """How many boxes were delivered by all robots."""
        return int(self._trial["delivered"][0])

    @property
    def robot_wait_s(self) -> npt.NDArray[np.float64]:
        """Each robot's current wait in seconds, 0 where it does not wait."""
        return self.motion.robots["wait_ticks"] / TICK_HZ

    def planned_path(self, robot: int) -> npt.NDArray[np.int16]:
        """Return int16[n, 2] cells (i, j) from the one the robot is in to its goal; empty if none.

        A bay has j = -1 or j = H, a home i = W.
        """
        r = self.motion.robots[robot]
        length = int(r["plan_length"])
        start = int(r["plan_at"])
        here = int(r["head"] if r["mode"] == FORWARD and r["s"] >= 0.3 else r["tail"])
        plan = self.motion.plans[robot]
        while start > 0 and plan[start] != here:
            start -= 1
        cells = [self.layout.index_cell(cell) for cell in plan[start:length].tolist()]
        return np.array(cells, dtype=np.int16).reshape(-1, 2)

    def planned_corners(self, robot: int) -> npt.NDArray[np.int16]:
        """Return int16[n, 2]: the first cell of `planned_path`, those where it turns, the last.

        The array is used again by the next call.
        """
        plans, stride = self.motion.plans, self.layout.stride
        count = outline_path(self.motion.robots, plans, robot, stride, self._corners)
        return self._corners[:count]

    def outline(self, per_m: float) -> list[int]:
        """Return all that moves, in few whole numbers; see `outline_world`."""
        outline_world(self._trial, self.motion.robots, per_m, self._numbers)
        return self._numbers.tolist()

    def state_hash(self) -> bytes:
        """Return 8 bytes over all bits of the state: equal worlds give equal hashes."""
        return hash_state(self.motion)

    def measures(self) -> TrialMeasures:
        """Return the trial's measures as they stand."""
        return measure_trial(self.motion)


def compile_kernels() -> None:
    """Compile, or load from the cache, everything that `World.step` runs: up to half a minute."""
    world = World(build_layout(PRESETS["practice"]), seed=0)
    world.step([(KEY_W, 0)])
    world.outline(1.0)
    world.planned_corners(0)
