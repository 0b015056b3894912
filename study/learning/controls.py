"""Policies that nobody learned: what a learned one has to be held against.

all_off   shows nothing, ever
no_ghost  shows live location and trajectory of every robot, always, and no balloon: ARROCH without
          its transparent avatars, the best of the tables made by hand in an earlier prototype
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from study.ar.elements import Element
from study.ar.state_names import ROBOT_STATES, STATION_STATES
from study.ar.thresholds import Thresholds
from study.errors import InvalidValue
from study.learning.policy import Policy

CONTROLS: Mapping[str, int] = MappingProxyType(
    {"all_off": 0, "no_ghost": int(Element.LIVE_LOCATION | Element.TRAJECTORY)}
)
"""What each shows of every robot, in every state."""


def control_policy(name: str, thresholds: Thresholds | None = None) -> Policy:
    """Return the control of this name. Errors: InvalidValue naming those that exist."""
    if name not in CONTROLS:
        raise InvalidValue(
            f"there is no control “{name[:40]}”", next_step=f"Use one of: {', '.join(CONTROLS)}."
        )
    return Policy(
        name=name,
        origin="control",
        thresholds=thresholds or Thresholds(),
        robot_table=(CONTROLS[name],) * len(ROBOT_STATES),
        station_table=(0,) * len(STATION_STATES),
    )
