"""The paper's claims (i) to (iii) as rules on numbers, fixed before any result was seen.

(i) discrepancies of VARIL fall steeply over the iterations while ARROCH's stay flat; (ii) waiting
under VARIL is shorter than under ARROCH and CRMIAR for most teams; (iii) waiting moves left from P1
to P6. A rule says `found`, `not found`, or that the opposite was found. Intervals are bootstrap
intervals; there are no p-values, since the number of simulated teams is ours to choose.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from study.analysis.intervals import Floats, Interval, bootstrap_mean
from study.analysis.paired import Difference
from study.errors import InvalidValue

PART = 6
STEEP = 0.5
FLAT = 0.25


class Verdict(StrEnum):
    """What a run says about a claim."""

    FOUND = "found"
    NOT_FOUND = "not found"
    OPPOSITE = "the opposite was found"


@dataclass(frozen=True)
class Fall:
    """A line's mean over the first and the last sixth of the iterations, and the change per run."""

    early: float
    late: float
    change: Interval

    @property
    def share(self) -> float:
        """The change as a share of the early value; 0 where that is 0."""
        return (self.late - self.early) / self.early if self.early else 0.0


def measure_fall(series: Floats, seed: int) -> Fall:
    """Compare the ends of float64[runs, J]. Errors: InvalidValue for an empty table."""
    table = np.asarray(series, np.float64)
    if table.ndim != 2 or not table.size:
        raise InvalidValue(f"a fall needs runs and iterations, not a table {table.shape}")
    part = max(1, table.shape[1] // PART)
    early, late = table[:, :part].mean(axis=1), table[:, -part:].mean(axis=1)
    change = bootstrap_mean(late - early, seed)
    return Fall(float(early.mean()), float(late.mean()), change)


def judge_discrepancies(own: Fall, reference: Fall) -> Verdict:
    """Claim (i): ours falls (its whole interval below 0) to half or less, the reference's mean
    stays within a quarter. The opposite: ours rises."""
    if own.change.low > 0:
        return Verdict.OPPOSITE
    falls = own.change.high < 0 and own.late <= STEEP * own.early
    flat = abs(reference.share) <= FLAT
    return Verdict.FOUND if falls and flat else Verdict.NOT_FOUND


def judge_shorter(pairs: Iterable[Difference]) -> Verdict:
    """Claim (ii): against every reference the mean is shorter and most teams wait less."""
    each = list(pairs)
    if all(pair.seconds.high < 0 and pair.shorter.low > 0.5 for pair in each):
        return Verdict.FOUND
    if all(pair.seconds.low > 0 and pair.shorter.high < 0.5 for pair in each):
        return Verdict.OPPOSITE
    return Verdict.NOT_FOUND


def judge_left(pair: Difference) -> Verdict:
    """Claim (iii): the last policy's mean lies left of the first's, with its whole interval."""
    if pair.seconds.high < 0:
        return Verdict.FOUND
    return Verdict.OPPOSITE if pair.seconds.low > 0 else Verdict.NOT_FOUND


def detectable_s(differences: Floats) -> float:
    """Smallest mean difference that so many pairs find in 4 of 5 cases, at 5 % on both sides."""
    sample = np.asarray(differences, np.float64)
    if len(sample) < 2:
        raise InvalidValue("two pairs are needed to know how they scatter")
    return float((1.96 + 0.8416) * sample.std(ddof=1) / np.sqrt(len(sample)))
