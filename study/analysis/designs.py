"""Complete cases: every participant with one value in every condition, and who was left out.

The design is within-subject. A participant counts for a measure only with a value in each
condition; nothing is filled in, and nobody disappears without a reason.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import numpy.typing as npt

from study.analysis.wording import count
from study.errors import StudyError

Floats = npt.NDArray[np.float64]
REFERENCE = "varil"


class Untestable(StudyError):
    """These data do not allow this test; the sentence says why."""


@dataclass(frozen=True)
class Reading:
    """One value of one participant: condition, position (1-based) and value."""

    participant: str
    condition: str
    position: int
    value: float


@dataclass(frozen=True)
class LeftOut:
    """A participant who does not count for a measure, and why."""

    participant: str
    reason: str


@dataclass(frozen=True)
class Design:
    """Complete cases of one measure.

    `values` is float64[participants, conditions]; a participant's repeated trials of one condition
    are averaged there and kept apart in `readings`.
    """

    measure: str
    conditions: tuple[str, ...]
    participants: tuple[str, ...]
    values: Floats
    readings: tuple[Reading, ...]
    left_out: tuple[LeftOut, ...] = ()

    @property
    def n(self) -> int:
        """Number of participants."""
        return len(self.participants)

    def column(self, condition: str) -> Floats:
        """Values of one condition, a row per participant."""
        return np.asarray(self.values[:, self.conditions.index(condition)], np.float64)

    def differences(self, first: str, second: str) -> Floats:
        """First minus second, per participant."""
        return np.asarray(self.column(first) - self.column(second), np.float64)


@dataclass(frozen=True)
class Pairs:
    """Which conditions are compared, and whether that was planned before the data."""

    pairs: tuple[tuple[str, str], ...]
    planned: bool


def complete_cases(
    measure: str,
    readings: Sequence[Reading],
    conditions: Sequence[str],
    participants: Sequence[str],
    reasons: Mapping[tuple[str, str], str],
) -> Design:
    """Keep participants with a value in each condition.

    Args:
        measure: name of the measured column or item.
        readings: all values at hand.
        conditions: the design's conditions, in the order of the tables.
        participants: who could have values, in the order of the tables.
        reasons: why (participant, condition) has no value, where that is known.
    """
    found: dict[tuple[str, str], list[float]] = {}
    for reading in readings:
        found.setdefault((reading.participant, reading.condition), []).append(reading.value)
    kept: list[str] = []
    left_out: list[LeftOut] = []
    for person in participants:
        missing = [name for name in conditions if (person, name) not in found]
        if missing:
            told = (f"{name}: {reasons.get((person, name), 'no value')}" for name in missing)
            left_out.append(LeftOut(person, "; ".join(told)))
        else:
            kept.append(person)
    whole = set(kept)
    table = [[float(np.mean(found[person, name])) for name in conditions] for person in kept]
    return Design(
        measure,
        tuple(conditions),
        tuple(kept),
        np.array(table, np.float64).reshape(len(kept), len(conditions)),
        tuple(r for r in readings if r.participant in whole and r.condition in conditions),
        tuple(left_out),
    )


def order_conditions(names: Sequence[str]) -> tuple[str, ...]:
    """The conditions as tables show them: `varil` first, the others by name."""
    return tuple(sorted(set(names), key=lambda name: (name != REFERENCE, name)))


def choose_pairs(conditions: Sequence[str]) -> Pairs:
    """`varil` against each other condition; without it, all pairs, which are descriptive only."""
    if REFERENCE in conditions:
        others = (name for name in conditions if name != REFERENCE)
        return Pairs(tuple((REFERENCE, name) for name in others), planned=True)
    return Pairs(tuple(combinations(conditions, 2)), planned=False)


def require(design: Design, participants: int, conditions: int = 2) -> None:
    """Raise `Untestable` unless the design has that many participants and conditions."""
    for number, least, noun, where in (
        (design.n, participants, "participant", "with complete data"),
        (len(design.conditions), conditions, "condition", "in the data"),
    ):
        if number < least:
            verb = "are" if number > 1 else "is"
            raise Untestable(
                f"there {verb} {count(number, noun)} {where}, and at least {least} are needed"
            )


def positive_cases(design: Design) -> Design:
    """The design without participants who have a value of 0 or less, which has no logarithm."""
    out = {reading.participant for reading in design.readings if reading.value <= 0}
    rows = [place for place, code in enumerate(design.participants) if code not in out]
    return replace(
        design,
        participants=tuple(design.participants[place] for place in rows),
        values=design.values[rows],
        readings=tuple(one for one in design.readings if one.participant not in out),
        left_out=(*design.left_out, *(LeftOut(code, "a value of 0") for code in sorted(out))),
    )
