"""The conditions of the study: who or what decides which elements are visible.

A condition answers one question, "what is visible now?", from what the AR agents may know. To
add one, write a class, enter it in `CONDITIONS` and run `study.ar.examination` on it. The two
reference systems show what the paper says they show; `none` and `full` are its figures 1a and 1b.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol

import numpy as np

from study.ar.elements import AGENT_ELEMENTS, Display, Element, Overlay
from study.ar.situation import ObservedWorld
from study.ar.states import robot_states, station_states
from study.errors import PolicyError, UnknownCondition

if TYPE_CHECKING:
    from study.ar.thresholds import Thresholds


class Condition(Protocol):
    """Decides what is visible. It keeps no state: the same question has the same answer."""

    def decide(self, world: ObservedWorld, previous: Display) -> Display:
        """What is to be visible now, given what has been displayed since the last decision."""
        ...


class PolicyTables(Protocol):
    """What a condition needs of a visualization policy: two lookup tables and their borders."""

    @property
    def robot_table(self) -> Sequence[int]:
        """Action of a robot's agent (0 to 7) by state (0 to 143)."""
        ...

    @property
    def station_table(self) -> Sequence[int]:
        """Action of a station's agent (0 or 1) by state (0 to 17)."""
        ...

    @property
    def thresholds(self) -> Thresholds:
        """Borders of the states."""
        ...


class Varil:
    """Every agent looks its own state up in the policy [paper]; nothing is decided centrally."""

    def __init__(self, policy: PolicyTables) -> None:
        self._robot_table = np.array(policy.robot_table, np.uint8)
        self._station_table = np.array(policy.station_table, np.uint8)
        self._thresholds = policy.thresholds

    def decide(self, world: ObservedWorld, previous: Display) -> Display:
        """Each agent's action for its own state."""
        robots = self._robot_table[robot_states(world, previous, self._thresholds)]
        stations = self._station_table[station_states(world, self._thresholds)]
        return Display(robots.tobytes(), stations.tobytes())


class Arroch:
    """ARROCH: trajectory, solid and transparent avatar of every robot, always [paper]."""

    def decide(self, world: ObservedWorld, previous: Display) -> Display:
        """The same elements for every robot."""
        return _for_all(world, AGENT_ELEMENTS, balloons=False)


class Crmiar:
    """CRMIAR: trajectory with beads of every robot, minimap and off-screen arrows [paper]."""

    def decide(self, world: ObservedWorld, previous: Display) -> Display:
        """The same elements for every robot, and both overlays."""
        overlays = Overlay.MINIMAP | Overlay.OFFSCREEN_ARROWS
        elements = Element.TRAJECTORY | Element.PATH_BEADS
        return _for_all(world, elements, balloons=False, overlays=overlays)


class Nothing:
    """No AR element at all, for practice, pilots and controls."""

    def decide(self, world: ObservedWorld, previous: Display) -> Display:
        """The empty display."""
        return _for_all(world, Element(0), balloons=False)


class Everything:
    """Every element a policy can switch, always: what the initial policy shows [paper]."""

    def decide(self, world: ObservedWorld, previous: Display) -> Display:
        """All of it."""
        return _for_all(world, AGENT_ELEMENTS, balloons=True)


def _for_all(
    world: ObservedWorld, elements: Element, *, balloons: bool, overlays: Overlay = Overlay(0)
) -> Display:
    robots, stations = len(world.robot_x_m), len(world.layout.stations)
    return Display(bytes([elements]) * robots, bytes([balloons]) * stations, int(overlays))


def _build_varil(policy: PolicyTables | None) -> Condition:
    if policy is None:
        raise PolicyError(
            "the condition “varil” runs a policy and none was given",
            next_step="Name a policy file in the study, or use the shipped one.",
        )
    return Varil(policy)


ConditionBuilder = Callable[[PolicyTables | None], Condition]

CONDITIONS: Mapping[str, ConditionBuilder] = MappingProxyType(
    {
        "varil": _build_varil,
        "arroch": lambda _: Arroch(),
        "crmiar": lambda _: Crmiar(),
        "none": lambda _: Nothing(),
        "full": lambda _: Everything(),
    }
)


def build_condition(name: str, policy: PolicyTables | None = None) -> Condition:
    """The condition of this name; UnknownCondition, or PolicyError when it lacks its policy."""
    if name not in CONDITIONS:
        raise UnknownCondition(name, tuple(CONDITIONS))
    return CONDITIONS[name](policy)
