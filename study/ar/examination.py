"""The examination every condition has to pass; whoever writes one runs it.

It fails, it never warns: an ExaminationFailed says what was asked and what came. It puts the
condition before situations in several halls and checks that its answers fit the hall, depend on
nothing hidden, and that no agent's own business changes what another one shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from study.ar.conditions import Condition
from study.ar.elements import Display, Element, Overlay
from study.ar.situation import Situation
from study.warehouse.layout import PRESETS, Layout, build_layout

ALL_ELEMENTS = sum(Element)
ALL_OVERLAYS = sum(Overlay)
SITUATIONS_PER_HALL = 25
HALLS = ("practice", "small", "study", "lab")
WAITING = 3


class ExaminationFailed(AssertionError):
    """The condition does not keep the contract; the sentence says where."""


def examine_condition(build: Callable[[], Condition], seed: int = 1) -> int:
    """Examine what `build` makes; returns how many situations it was put before."""
    asked = 0
    for hall in HALLS:
        layout = build_layout(PRESETS[hall])
        condition, twin = build(), build()
        for situation, previous in draw_situations(layout, seed, SITUATIONS_PER_HALL):
            where = f"hall {hall}, situation {asked}"
            answer = condition.decide(situation, previous)
            _check_shape(answer, situation, where)
            _check_memory(condition, twin, situation, previous, answer, where)
            _check_own_business(condition, situation, previous, answer, where)
            asked += 1
    return asked


def draw_situations(layout: Layout, seed: int, count: int) -> Iterator[tuple[Situation, Display]]:
    """Random but repeatable situations in a hall, each with a display that was shown before."""
    draws = np.random.default_rng(seed)
    robots, stations = layout.spec.robots, len(layout.stations)
    rows, columns = np.nonzero(layout.free)
    for number in range(count):
        cells = draws.integers(0, len(rows), robots + 1)
        x_m = np.asarray(0.3 + 0.6 * columns[cells], np.float64)
        y_m = np.asarray(0.9 + 0.6 * rows[cells], np.float64)
        state = draws.integers(0, 7, robots).astype(np.int8)
        waits = (state == WAITING) * draws.uniform(0.0, 60.0, robots)
        yield (
            Situation(
                layout,
                30 * number,
                float(x_m[-1]),
                float(y_m[-1]),
                x_m[:-1],
                y_m[:-1],
                state,
                draws.integers(-1, 4, robots).astype(np.int8),
                draws.integers(0, stations, robots).astype(np.int8),
                draws.integers(0, 4, robots),
                waits,
            ),
            Display(
                draws.integers(0, 8, robots).astype(np.uint8).tobytes(),
                draws.integers(0, 2, stations).astype(np.uint8).tobytes(),
            ),
        )


def _check_shape(answer: Display, situation: Situation, where: str) -> None:
    robots, stations = len(situation.robot_x_m), len(situation.layout.stations)
    _demand(len(answer.robots) == robots, f"{len(answer.robots)} masks, not {robots}", where)
    _demand(
        len(answer.stations) == stations, f"{len(answer.stations)} balloons, not {stations}", where
    )
    _demand(max(answer.robots) <= ALL_ELEMENTS, "an unknown element of a robot", where)
    _demand(max(answer.stations) <= 1, "a balloon that is neither 0 nor 1", where)
    _demand(0 <= answer.overlays <= ALL_OVERLAYS, "an unknown overlay", where)


def _check_memory(
    condition: Condition,
    twin: Condition,
    situation: Situation,
    previous: Display,
    answer: Display,
    where: str,
) -> None:
    _demand(
        condition.decide(situation, previous) == answer, "asked again, it answers otherwise", where
    )
    fresh = twin.decide(situation, previous)
    _demand(fresh == answer, "one made afresh answers otherwise: it hides a state", where)


def _check_own_business(
    condition: Condition, situation: Situation, previous: Display, answer: Display, where: str
) -> None:
    """A robot's box, tasks and wait concern its own elements and its station's balloon only."""
    for robot in range(len(situation.robot_x_m)):
        changed = replace(
            situation,
            robot_carrying=_with(situation.robot_carrying, robot, 2),
            robot_remaining=_with(situation.robot_remaining, robot, 3),
            robot_wait_s=_with(situation.robot_wait_s, robot, 45.0),
        )
        other = condition.decide(changed, previous)
        same = _without(other.robots, robot) == _without(answer.robots, robot)
        _demand(same, f"what robot {robot} carries changes what others show", where)
        station = int(situation.robot_station[robot])
        balloons = _without(other.stations, station) == _without(answer.stations, station)
        _demand(balloons, f"robot {robot}'s wait changes a balloon of another station", where)


def _with(values: np.ndarray, index: int, value: float) -> np.ndarray:
    copy = values.copy()
    copy[index] = value
    return copy


def _without(masks: Sequence[int], index: int) -> list[int]:
    return [mask for at, mask in enumerate(masks) if at != index]


def _demand(holds: bool, complaint: str, where: str) -> None:
    if not holds:
        raise ExaminationFailed(f"{where}: {complaint}")
