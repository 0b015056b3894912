"""The six strongest parameters of the simulated people, to be halved and doubled.

Which six was decided before any result of this program, from a table that an earlier prototype had
made: those whose halving or doubling moved its comparison of displays furthest.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType

from study.errors import InvalidValue
from study.people.habits import Habits
from study.warehouse.halls import HallSpec

WALKING_SPEED = "walking speed"
STRONGEST: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        WALKING_SPEED: (),
        "the expert's times": (
            "expert.react_s",
            "expert.decide_s",
            "expert.point_s",
            "expert.click_s",
            "expert.next_box_s",
        ),
        "noticing while walking": ("worker.walking_factor",),
        "time of a decision": ("worker.decide_s",),
        "what the expert calls near": ("expert.near_m",),
        "what the expert calls soon": ("expert.soon_s",),
    }
)
"""Parameters that are varied together, by what they stand for; the walking speed is the hall's."""


def vary(what: str, factor: float, habits: Habits, spec: HallSpec) -> tuple[Habits, HallSpec]:
    """Return habits and hall with one of `STRONGEST` multiplied.

    Errors: InvalidValue for another name; LayoutError for a walking speed off the scale.
    """
    if what not in STRONGEST:
        raise InvalidValue(
            f"“{what[:40]}” is not varied", next_step=f"Use one of: {', '.join(STRONGEST)}."
        )
    if what == WALKING_SPEED:
        faster = spec.human_speed_mps * factor
        return habits, dataclasses.replace(spec, human_speed_mps=faster)
    return habits.scaled(STRONGEST[what], factor), spec
