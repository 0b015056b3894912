"""What a trial measures: per trial, per robot and per leg. Seconds and metres.

The paper plots the sum of waits, tests the sum of completion times and calls the slowest robot's
time the team's; all three are always recorded.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from study.warehouse.halls import TICK_HZ
from study.warehouse.state import HOME_STATE, LEG, STATUSES, Motion, RobotState


@dataclass(frozen=True)
class RobotMeasures:
    """One robot's trial. `completion_s`: when it was home for good, or the trial's end if never.

    `longest_stall_s`: longest time under way without coming nearer to the goal, times taken off in
    which the human covered the mouth of its bay or home; `blocked_by_human_s`: those times.
    """

    robot: int
    boxes_delivered: int
    wait_s: float
    completion_s: float
    path_m: float
    longest_stall_s: float
    blocked_by_human_s: float


@dataclass(frozen=True)
class Leg:
    """A stretch of a robot's life in one state; shelf, box and station are -1 where none applies.

    `ended` is false for the leg that was cut off by the trial's end or is still going on.
    """

    robot: int
    leg: int
    state: str
    start_s: float
    end_s: float
    path_m: float
    shelf: int
    box: int
    station: int
    ended: bool


@dataclass(frozen=True)
class TrialMeasures:
    """A whole trial; `robots` and `legs` in order of robot, legs then in order of time."""

    status: str
    ticks: int
    duration_s: float
    boxes_delivered: int
    sum_wait_s: float
    sum_completion_s: float
    slowest_robot_s: float
    human_path_m: float
    human_still_s: float
    blocked_by_human_s: float
    longest_stall_s: float
    overlaps: int
    robots: tuple[RobotMeasures, ...]
    legs: tuple[Leg, ...]


def seconds(ticks: float) -> float:
    """Return ticks of 1/30 s in seconds."""
    return round(ticks / TICK_HZ, 6)


def measure_robots(motion: Motion) -> tuple[RobotMeasures, ...]:
    """Return every robot's measures so far."""
    ticks = int(motion.trial["tick"][0])
    return tuple(
        RobotMeasures(
            robot=k,
            boxes_delivered=int(r["delivered"]),
            wait_s=seconds(int(r["waited_ticks"]) + int(r["wait_ticks"])),
            completion_s=seconds(int(r["done_tick"]) if r["done_tick"] >= 0 else ticks),
            path_m=round(float(r["path_m"]), 6),
            longest_stall_s=seconds(int(r["longest_stall"])),
            blocked_by_human_s=seconds(int(r["blocked"])),
        )
        for k, r in enumerate(motion.robots)
    )


def measure_legs(motion: Motion) -> tuple[Leg, ...]:
    """Return every leg so far; the ones still going on end now."""
    now = int(motion.trial["tick"][0])
    rows = [(leg, True) for leg in motion.legs[: int(motion.trial["legs"][0])]]
    rows += [(leg, False) for leg in _open_legs(motion, now)]
    rows.sort(key=lambda row: (int(row[0]["robot"]), int(row[0]["start"]), int(row[0]["end"])))
    legs: list[Leg] = []
    for leg, ended in rows:
        robot = int(leg["robot"])
        legs.append(
            Leg(
                robot=robot,
                leg=legs[-1].leg + 1 if legs and legs[-1].robot == robot else 0,
                state=RobotState(int(leg["state"])).name.lower(),
                start_s=seconds(int(leg["start"])),
                end_s=seconds(int(leg["end"])),
                path_m=round(float(leg["path_m"]), 6),
                shelf=int(leg["shelf"]),
                box=int(leg["box"]),
                station=int(leg["station"]),
                ended=ended,
            )
        )
    return tuple(legs)


def _open_legs(motion: Motion, now: int) -> list[Any]:
    rows = []
    for k, r in enumerate(motion.robots):
        if now == 0 or r["state"] == HOME_STATE:
            continue
        leg = np.zeros(1, dtype=LEG)
        for name in ("state", "shelf", "box", "station"):
            leg[name] = r[name]
        leg["robot"], leg["start"], leg["end"] = k, r["leg_start"], now
        leg["path_m"] = r["path_m"] - r["leg_path_m"]
        rows.append(leg[0])
    return rows


def measure_trial(motion: Motion) -> TrialMeasures:
    """Return the trial's measures as they stand."""
    trial = motion.trial[0]
    robots = measure_robots(motion)
    return TrialMeasures(
        status=STATUSES[int(trial["status"])],
        ticks=int(trial["tick"]),
        duration_s=seconds(int(trial["tick"])),
        boxes_delivered=int(trial["delivered"]),
        sum_wait_s=round(sum(r.wait_s for r in robots), 6),
        sum_completion_s=round(sum(r.completion_s for r in robots), 6),
        slowest_robot_s=max(r.completion_s for r in robots),
        human_path_m=round(float(trial["path_m"]), 6),
        human_still_s=seconds(int(trial["still_ticks"])),
        blocked_by_human_s=round(sum(r.blocked_by_human_s for r in robots), 6),
        longest_stall_s=max(r.longest_stall_s for r in robots),
        overlaps=int(trial["overlaps"]),
        robots=robots,
        legs=measure_legs(motion),
    )
