"""What the parts of a report share: results with sentences, and tests that could not be made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from study.analysis.designs import Untestable
from study.analysis.mixed import Ratio
from study.analysis.sheets import Section

Found = TypeVar("Found")
UNPLANNED = (
    "No condition is `varil`, so no contrast was planned: pairs are described with intervals, "
    "without p-values."
)


@dataclass(frozen=True)
class Tested:
    """A section, and a sentence per finding or per test that could not be made."""

    section: Section
    findings: tuple[str, ...]
    ratios: tuple[Ratio, ...] = ()


def attempt(what: str, test: Callable[[], Found]) -> tuple[Found | None, str]:
    """The test's result, or None and a sentence that says why there is none."""
    try:
        return test(), ""
    except Untestable as error:
        return None, f"{what}: not tested ({error.what})."
