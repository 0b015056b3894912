"""Which elements each condition can show: what an explanation page is built from.

The robots' and stations' elements are the paper's; `none` and `full` are controls. A participant
meets conditions only as “Display A, B, C”, lettered in the order met.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

ConditionName = Literal["varil", "arroch", "crmiar", "none", "full"]


@dataclass(frozen=True)
class ShownElements:
    """Element names as in the pictures' file names, and whether they come and go."""

    names: tuple[str, ...]
    adaptive: bool = False


_ROBOT = ("trajectory", "live-location", "transparent-avatar")

SHOWN: Mapping[str, ShownElements] = {
    "varil": ShownElements((*_ROBOT, "balloon"), adaptive=True),
    "arroch": ShownElements(_ROBOT),
    "crmiar": ShownElements(("trajectory", "path-beads", "minimap", "offscreen-arrows")),
    "none": ShownElements(()),
    "full": ShownElements((*_ROBOT, "balloon")),
}


def display_label(position: int) -> str:
    """What participants call the condition at this position (1-based): “Display A” and so on."""
    return f"Display {chr(ord('A') + position - 1)}"
