"""What the AR agents may know of the world at one moment, as a protocol and as a plain record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from study.warehouse.layout import Layout

Floats = NDArray[np.float64]
Ints = NDArray[Any]


class ObservedWorld(Protocol):
    """The part of a world that conditions look at; arrays have one entry per robot.

    Positions in metres, waits in seconds; `robot_carrying` and `robot_station` are -1 for none;
    `robot_remaining` counts boxes not yet unloaded, a carried one included.
    """

    @property
    def layout(self) -> Layout:
        """The hall."""
        ...

    @property
    def tick(self) -> int:
        """Ticks of 1/30 s since the start."""
        ...

    @property
    def human_x_m(self) -> float:
        """The human's place."""
        ...

    @property
    def human_y_m(self) -> float:
        """The human's place."""
        ...

    @property
    def robot_x_m(self) -> Floats:
        """Places of the robots."""
        ...

    @property
    def robot_y_m(self) -> Floats:
        """Places of the robots."""
        ...

    @property
    def robot_carrying(self) -> Ints:
        """Colour of the carried box."""
        ...

    @property
    def robot_station(self) -> Ints:
        """The station a robot is bound for or stands at."""
        ...

    @property
    def robot_remaining(self) -> Ints:
        """Boxes still to be unloaded."""
        ...

    @property
    def robot_wait_s(self) -> Floats:
        """The current wait; 0 when not waiting."""
        ...

    @property
    def robot_state(self) -> Ints:
        """Values of RobotState."""
        ...


@dataclass
class Situation:
    """An ObservedWorld made by hand, for examinations, tests and tables of examples."""

    layout: Layout
    tick: int
    human_x_m: float
    human_y_m: float
    robot_x_m: Floats
    robot_y_m: Floats
    robot_state: Ints
    robot_carrying: Ints
    robot_station: Ints
    robot_remaining: Ints
    robot_wait_s: Floats
