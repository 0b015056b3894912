"""The elements of the AR display and the record of what is visible."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag


class Element(IntFlag):
    """What may be shown of one robot. The first three are the actions of a robot's agent [paper].

    In a policy's tables an action is the sum of the first three bits: 8 classes.
    """

    LIVE_LOCATION = 1
    TRANSPARENT_AVATAR = 2
    TRAJECTORY = 4
    PATH_BEADS = 8


class Overlay(IntFlag):
    """What may be shown over the whole view."""

    MINIMAP = 1
    OFFSCREEN_ARROWS = 2


AGENT_ELEMENTS = Element.LIVE_LOCATION | Element.TRANSPARENT_AVATAR | Element.TRAJECTORY
"""The elements a robot's AR agent decides on."""

PATH_ELEMENTS = Element.TRANSPARENT_AVATAR | Element.TRAJECTORY | Element.PATH_BEADS
"""The elements for which the browser must know a robot's planned path."""

ROBOT_ACTIONS = 8
STATION_ACTIONS = 2


@dataclass(frozen=True)
class Display:
    """What is visible: one mask byte per robot, one 0/1 byte per station, the overlays."""

    robots: bytes
    stations: bytes
    overlays: int = 0

    @classmethod
    def nothing(cls, robots: int, stations: int) -> Display:
        """The empty display for so many robots and stations."""
        return cls(bytes(robots), bytes(stations))
