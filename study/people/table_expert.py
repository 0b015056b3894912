"""The table expert: a fixed table of the agents' states, without delay and without slips.

It tests the algorithm and says nothing about people. The table was written down before any run:

robot, picking     human close: trajectory; else nothing
robot, dropping    human close: live location; else live location and trajectory
station            balloon while robots wait and the human is not close
"""

from __future__ import annotations

from collections.abc import Sequence

from study.ar.elements import Display, Element
from study.ar.situation import ObservedWorld
from study.ar.state_names import ROBOT_STATES, STATION_STATES
from study.learning.boxes import Checkboxes


def robot_answer(state: str) -> int:
    """The elements this expert wants for a robot in a state, by the state's name."""
    human, task, *_ = state.split("/")
    if task == "picking":
        return int(Element.TRAJECTORY) if human == "close" else 0
    alone = Element.LIVE_LOCATION
    return int(alone if human == "close" else alone | Element.TRAJECTORY)


def station_answer(state: str) -> int:
    """1 for a balloon at a station in a state, by the state's name."""
    human, _, waiting = state.split("/")
    return int(waiting == "many" and human != "close")


ROBOT_ANSWERS = tuple(robot_answer(state) for state in ROBOT_STATES)
STATION_ANSWERS = tuple(station_answer(state) for state in STATION_STATES)


class TableExpert:
    """Sets every agent's boxes to the table's answer at once."""

    def __init__(self) -> None:
        self._tick = 0

    def act(self, world: ObservedWorld, display: Display, boxes: Checkboxes, tick: int) -> None:
        """Take note of the time; `tick` counts over the whole run."""
        del world, display, boxes
        self._tick = tick

    def answer(self, boxes: Checkboxes, states: Sequence[int]) -> None:
        """Set the boxes of all agents for their present states."""
        for agent, state in enumerate(states):
            table = ROBOT_ANSWERS if agent < boxes.robots else STATION_ANSWERS
            boxes.set(agent, table[state], self._tick)
