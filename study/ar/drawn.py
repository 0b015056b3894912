"""Which elements could draw anything at a moment, whether switched on or not [our choice].

A robot that picks, waits, unloads or is home has no path, so its ribbon and ghost draw nothing; a
balloon stands for somebody who waits, so above a station where nobody does it marks nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from study.ar.elements import AGENT_ELEMENTS, Element
from study.warehouse.state import RobotState

if TYPE_CHECKING:
    from study.ar.situation import ObservedWorld

DRIVING = (RobotState.TO_SHELF, RobotState.TO_STATION, RobotState.RETURNING)


def drawn_elements(world: ObservedWorld) -> list[int]:
    """Return a mask per agent, robots first, then stations."""
    driving = np.isin(world.robot_state, DRIVING)
    robots = np.where(driving, int(AGENT_ELEMENTS), int(Element.LIVE_LOCATION)).tolist()
    waiting = world.robot_state == RobotState.WAITING
    marked = set(np.asarray(world.robot_station)[waiting].tolist())
    return [*robots, *(int(station in marked) for station in range(len(world.layout.stations)))]
