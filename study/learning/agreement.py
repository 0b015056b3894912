"""How far experts agree with the one who leads: Cohen's kappa for each element.

Compared are the settings at the snapshots, for elements that could draw anything. Source: J.
Cohen, A coefficient of agreement for nominal scales, 1960.
"""

from __future__ import annotations

from typing import NamedTuple

ELEMENTS = ("live_location", "transparent_avatar", "trajectory", "balloon")
BALLOON = 3


class Setting(NamedTuple):
    """What an expert without the lead had set for an agent at a snapshot, and the lead's mask.

    agent: robots first, then stations. drawn: elements that could draw anything. tick: of the
    trial.
    """

    trial: int
    tick: int
    expert: str
    agent: int
    mask: int
    lead_mask: int
    drawn: int


class Agreement:
    """Counts settings of one element against the lead's: both on, one of the two, neither."""

    def __init__(self, robots: int) -> None:
        self._robots = robots
        self._counts: dict[str, list[list[int]]] = {}

    def add(self, setting: Setting) -> None:
        """Count one agent's elements at one snapshot."""
        tables = self._counts.setdefault(setting.expert, [[0, 0, 0, 0] for _ in ELEMENTS])
        station = setting.agent >= self._robots
        for bit, element in enumerate((BALLOON,) if station else range(BALLOON)):
            if setting.drawn >> bit & 1:
                mine, lead = setting.mask >> bit & 1, setting.lead_mask >> bit & 1
                tables[element][mine << 1 | lead] += 1

    def experts(self) -> tuple[str, ...]:
        """Those who were compared at least once, in the order of their first snapshot."""
        return tuple(self._counts)

    def pairs(self, expert: str, element: str) -> int:
        """How many settings of this element were compared."""
        return sum(self._counts[expert][ELEMENTS.index(element)])

    def kappa(self, expert: str, element: str) -> float | None:
        """Cohen's kappa, 1 for full agreement; None where chance alone would agree always."""
        return kappa(*self._counts[expert][ELEMENTS.index(element)])


def kappa(neither: int, only_lead: int, only_mine: int, both: int) -> float | None:
    """Cohen's kappa of a two by two table of counts; None where it is not defined."""
    whole = neither + only_lead + only_mine + both
    mine, lead = only_mine + both, only_lead + both
    by_chance = mine * lead + (whole - mine) * (whole - lead)
    if by_chance == whole * whole:
        return None
    return ((neither + both) * whole - by_chance) / (whole * whole - by_chance)
