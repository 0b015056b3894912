"""What the parts of a report share: results with sentences, and tests that could not be made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from study.analysis.designs import Pairs, Untestable
from study.analysis.mixed import Ratio
from study.analysis.sheets import Section

Found = TypeVar("Found")
UNPLANNED = (
    "No condition is “varil”, so no contrast was planned: pairs are described with intervals, "
    "without p-values."
)


@dataclass(frozen=True)
class Gap:
    """A test that could not be made, and why."""

    what: str
    why: str


@dataclass(frozen=True)
class Tested:
    """A section, a sentence per finding, and the tests that could not be made."""

    section: Section
    findings: tuple[str, ...]
    gaps: tuple[Gap, ...] = ()
    ratios: tuple[Ratio, ...] = ()


def attempt(what: str, test: Callable[[], Found]) -> tuple[Found | None, list[Gap]]:
    """The test's result, or None and the gap that it leaves."""
    try:
        return test(), []
    except Untestable as error:
        return None, [Gap(what, error.what)]


def note_plan(pairs: Pairs) -> tuple[str, ...]:
    """What is to be said where pairs are compared that nobody planned; else nothing."""
    return (UNPLANNED,) if pairs.pairs and not pairs.planned else ()


def word_gaps(gaps: Sequence[Gap]) -> tuple[str, ...]:
    """A sentence per reason, naming everything that it left untested."""
    reasons: dict[str, list[str]] = {}
    for gap in gaps:
        reasons.setdefault(gap.why, []).append(gap.what)
    return tuple(f"Not tested, since {why}: {'; '.join(what)}." for why, what in reasons.items())
