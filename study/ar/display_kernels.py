"""A display that is decided and held inside compiled code, for trials without pictures.

It does what `conditions` and `display.DisplayClock` do, for conditions that can be written as one
action per state; a constant condition has the same action everywhere. A test holds them equal.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from study.ar.conditions import PolicyTables
from study.ar.display import BITS, HOLD_TICKS
from study.ar.distances import station_mouths
from study.ar.elements import AGENT_ELEMENTS, Display, Element, Overlay
from study.ar.state_kernels import code_robots, code_stations
from study.ar.state_names import ROBOT_STATES, STATION_STATES
from study.ar.thresholds import Thresholds
from study.errors import UnknownCondition
from study.warehouse.kernels import kernel
from study.warehouse.layout import Layout
from study.warehouse.routes import PAD, SHARED, UNREACHED, WALL, fill_marked
from study.warehouse.state import Floor, Motion

CRMIAR = int(Element.TRAJECTORY | Element.PATH_BEADS)
CONSTANT = {  # mask of each robot, balloon of each station, overlays
    "arroch": (int(AGENT_ELEMENTS), 0, 0),
    "crmiar": (CRMIAR, 0, int(Overlay.MINIMAP | Overlay.OFFSCREEN_ARROWS)),
    "none": (0, 0, 0),
    "full": (int(AGENT_ELEMENTS), 1, 0),
}


class Shown(NamedTuple):
    """What is displayed, what decides it, and scratch. N robots, S stations, C padded cells."""

    robots: npt.NDArray[np.uint8]  # [N] masks
    stations: npt.NDArray[np.uint8]  # [S] balloons
    overlays: npt.NDArray[np.uint8]  # [1]
    since: npt.NDArray[np.int64]  # [N + S, BITS] tick of each element's last change
    robot_table: npt.NDArray[np.uint8]  # [144]
    station_table: npt.NDArray[np.uint8]  # [18]
    constant: npt.NDArray[np.uint8]  # [1] 1 where the tables do not depend on the state
    borders: npt.NDArray[np.float64]  # [6]
    many: npt.NDArray[np.int64]  # [3]
    mouths: npt.NDArray[np.int64]  # [S, 2]
    robot_states: npt.NDArray[np.int16]  # [N]
    station_states: npt.NDArray[np.int16]  # [S]
    way: npt.NDArray[np.int16]  # [C]
    field: npt.NDArray[np.int32]  # [H, W]


def new_shown(layout: Layout, condition: str, policy: PolicyTables | None) -> Shown:
    """Return the display of a trial before its first decision.

    Errors: UnknownCondition, also for `varil` without its policy.
    """
    if condition not in CONSTANT and (policy is None or condition != "varil"):
        raise UnknownCondition(condition, (*CONSTANT, "varil with its policy"))
    robots, stations = layout.spec.robots, len(layout.stations)
    mask, balloon, overlays = CONSTANT.get(condition, (0, 0, 0))
    use = condition not in CONSTANT
    t = policy.thresholds if policy is not None and use else Thresholds()
    robot_table: Sequence[int] = [mask] * len(ROBOT_STATES)
    station_table: Sequence[int] = [balloon] * len(STATION_STATES)
    if policy is not None and use:
        robot_table, station_table = policy.robot_table, policy.station_table
    return Shown(
        robots=np.zeros(robots, np.uint8),
        stations=np.zeros(stations, np.uint8),
        overlays=np.array([overlays], np.uint8),
        since=np.zeros((robots + stations, BITS), np.int64),
        robot_table=np.array(robot_table, np.uint8),
        station_table=np.array(station_table, np.uint8),
        constant=np.array([not use], np.uint8),
        borders=np.array(
            [t.close_m, t.far_m, t.medium_wait_s, t.long_wait_s, t.nearby_m, t.many_shown_share]
        ),
        many=np.array([t.many_tasks, t.many_nearby, t.many_waiting], np.int64),
        mouths=station_mouths(layout),
        robot_states=np.zeros(robots, np.int16),
        station_states=np.zeros(stations, np.int16),
        way=np.zeros(layout.kinds.size, np.int16),
        field=np.zeros((layout.height_cells, layout.width_cells), np.int32),
    )


def show(shown: Shown, display: Display) -> None:
    """Take over a display that was decided outside."""
    shown.robots[:] = np.frombuffer(display.robots, np.uint8)
    shown.stations[:] = np.frombuffer(display.stations, np.uint8)
    shown.overlays[0] = display.overlays


@kernel
def fill_human_field(motion: Motion, shown: Shown, stride: int) -> None:
    """Fill `shown.field` with the steps from the human's nearest free cell, -1 unreachable."""
    trial = motion.trial[0]
    height, width = shown.field.shape
    best = -1
    nearest = 0.0
    i = min(max(int(np.floor(trial.x / 0.6)), 0), width - 1)
    j = min(max(int(np.floor((trial.y - 0.6) / 0.6)), 0), height - 1)
    own = (j + PAD) * stride + i + PAD
    for n in range(shown.way.size):
        free = motion.cells[n].kind == SHARED
        shown.way[n] = UNREACHED if free else WALL
    if motion.cells[own].kind == SHARED:
        best = own
    else:
        for n in range(shown.way.size):
            if motion.cells[n].kind == SHARED:
                dx = motion.cells[n].x - trial.x
                dy = motion.cells[n].y - trial.y
                if best < 0 or dx * dx + dy * dy < nearest:
                    best = n
                    nearest = dx * dx + dy * dy
    fill_marked(stride, np.array([best], dtype=np.int32), shown.way, motion.queue, -1)
    for row in range(height):
        for column in range(width):
            steps = shown.way[(row + PAD) * stride + column + PAD]
            shown.field[row, column] = steps if steps < WALL else -1


@kernel
def code_states(floor: Floor, motion: Motion, shown: Shown) -> None:
    """Fill the agents' states for the present world and display."""
    fill_human_field(motion, shown, floor.hall[0].stride)
    b = shown.borders
    borders = (b[0], b[1], b[2], b[3])
    robots = motion.robots
    wait_s = robots["wait_ticks"] / 30
    code_robots(
        shown.field, robots["x"], robots["y"], robots["carrying"], robots["remaining"], wait_s,
        shown.robots, borders, (b[4], b[5]), (shown.many[0], shown.many[1]), shown.robot_states,
    )  # fmt: skip
    code_stations(
        shown.field, shown.mouths, robots["state"], robots["station"], wait_s, borders,
        shown.many[2], shown.station_states,
    )  # fmt: skip


@kernel
def hold(old: np.int64, new: np.int64, since: npt.NDArray[np.int64], tick: int) -> np.int64:
    """Return the mask `old` with those changes to `new` whose element was held long enough."""
    for bit in range(BITS):
        if (old ^ new) >> bit & 1 and tick - since[bit] >= HOLD_TICKS:
            since[bit] = tick
            old ^= 1 << bit
    return old


@kernel
def refresh(floor: Floor, motion: Motion, shown: Shown) -> None:
    """Decide what is displayed from this tick on; call it at each decision tick."""
    tick = motion.trial[0].tick
    first = tick == 0
    if not first and shown.constant[0]:
        return
    if not shown.constant[0]:
        code_states(floor, motion, shown)
    robots = shown.robots.size
    for n in range(robots):
        wanted = np.int64(shown.robot_table[shown.robot_states[n]])
        old = np.int64(shown.robots[n])
        shown.robots[n] = wanted if first else hold(old, wanted, shown.since[n], tick)
    for n in range(shown.stations.size):
        wanted = np.int64(shown.station_table[shown.station_states[n]])
        old = np.int64(shown.stations[n])
        shown.stations[n] = wanted if first else hold(old, wanted, shown.since[robots + n], tick)
