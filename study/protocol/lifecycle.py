"""The life of a participation as one state machine; every change of it has a reason.

::

    joined --begin--> active <--pause / return--> paused
    joined, active, paused --> completed | screened-out | timed-out
    everything but withdrawn --> withdrawn
    everything but withdrawn --> excluded --reinstate--> what it was before

`change(life, act)` is the only way to move. An act that says again what is so already changes
nothing; one that does not fit raises `WrongChange`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, get_args

from study.errors import InvalidValue, WrongMoment

Status = Literal[
    "joined",
    "active",
    "paused",
    "completed",
    "screened-out",
    "withdrawn",
    "timed-out",
    "excluded",
]
Outcome = Literal["completed", "screened-out", "withdrawn", "timed-out", "excluded"]
Act = Literal[
    "begin",
    "pause",
    "return",
    "complete",
    "screen-out",
    "time-out",
    "withdraw",
    "exclude",
    "reinstate",
]
STATUSES: tuple[Status, ...] = get_args(Status)
OUTCOMES: tuple[Outcome, ...] = get_args(Outcome)
UNDER_WAY: tuple[Status, ...] = ("joined", "active", "paused")
LONGEST_REASON = 200

REASONS: Mapping[Act, str] = MappingProxyType(
    {
        "begin": "sent the first form",
        "pause": "nothing was heard for a while",
        "return": "came back",
        "complete": "did every step",
        "screen-out": "did not pass the practice",
        "time-out": "nothing was heard for the study's limit",
        "withdraw": "withdrew",
    }
)
"""What is noted for acts that need no reason of their own."""

_TARGETS: Mapping[Act, tuple[tuple[Status, ...], Status]] = MappingProxyType(
    {
        "begin": (("joined", "paused"), "active"),
        "pause": (("active",), "paused"),
        "return": (("paused",), "active"),
        "complete": (UNDER_WAY, "completed"),
        "screen-out": (UNDER_WAY, "screened-out"),
        "time-out": (UNDER_WAY, "timed-out"),
        "withdraw": (tuple(s for s in STATUSES if s != "withdrawn"), "withdrawn"),
        "exclude": (tuple(s for s in STATUSES if s not in ("withdrawn", "excluded")), "excluded"),
    }
)
_CHANGES_NOTHING: Mapping[Act, tuple[Status, ...]] = MappingProxyType(
    {
        "begin": ("active",),
        "pause": ("joined", "paused", *OUTCOMES),
        "return": ("joined", "active", *OUTCOMES),
        "time-out": OUTCOMES,
        "withdraw": ("withdrawn",),
    }
)


class WrongChange(WrongMoment):
    """A participation cannot change like this from where it is."""

    def __init__(self, act: Act, status: Status) -> None:
        self.act = act
        self.status = status
        super().__init__(
            f"“{act}” does not fit a participation that is {status}",
            next_step="Nothing was changed. Look at the participant's history first.",
        )


@dataclass(frozen=True)
class Life:
    """Where a participation stands; `before` is what it was before it was excluded."""

    status: Status = "joined"
    before: Status | None = None

    @property
    def outcome(self) -> Outcome | None:
        """How it ended, or None while it is under way."""
        return None if self.status in UNDER_WAY else self.status  # type: ignore[return-value]

    @property
    def told(self) -> Status:
        """What the participant is told: who had ended before being excluded keeps that end."""
        if self.status == "excluded" and self.before is not None and self.before not in UNDER_WAY:
            return self.before
        return self.status


def change(life: Life, act: Act) -> Life:
    """The life after an act; the same one if the act changes nothing. Raises `WrongChange`."""
    if act == "reinstate":
        if life.status != "excluded" or life.before is None:
            raise WrongChange(act, life.status)
        return Life(life.before)
    if life.status in _CHANGES_NOTHING.get(act, ()):
        return life
    sources, target = _TARGETS[act]
    if life.status not in sources:
        raise WrongChange(act, life.status)
    return Life(target, life.status if target == "excluded" else None)


def check_reason(reason: str) -> str:
    """A reason in one line; raises InvalidValue if it is empty or too long."""
    text = " ".join(reason.replace("\x00", "").split())
    if not text or len(text) > LONGEST_REASON:
        raise InvalidValue(
            f"a reason of 1 to {LONGEST_REASON} characters is needed, this one has {len(text)}",
            next_step="Say in a few words why; it is kept with the participant.",
        )
    return text
