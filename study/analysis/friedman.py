"""Friedman's test of several related samples, corrected for ties, with Kendall's W."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from study.analysis.designs import Design, Untestable, require


@dataclass(frozen=True)
class Friedman:
    """Chi-squared test over conditions; W in 0..1 is the participants' agreement in ranking."""

    measure: str
    n: int
    chi_squared: float
    df: int
    p: float
    kendall_w: float


def rank_conditions(design: Design) -> Friedman:
    """Test whether a condition is ranked above others (Hollander and Wolfe 1999, section 7.1).

    Errors: Untestable with fewer than 2 participants or 3 conditions, or if every participant
    gave the same value in all conditions.
    """
    require(design, 2, conditions=3)
    values = design.values
    n, k = values.shape
    ranks = stats.rankdata(values, axis=1)
    sizes = [np.unique(row, return_counts=True)[1] for row in values]
    ties = float(sum(np.sum(size**3.0 - size) for size in sizes))
    correction = n * k * (k + 1) - ties / (k - 1)
    if correction <= 1e-9:
        raise Untestable("every participant gave the same value in all conditions")
    excess = ranks.sum(axis=0) - n * (k + 1) / 2
    chi_squared = 12 * float(np.sum(excess**2)) / correction
    return Friedman(
        measure=design.measure,
        n=n,
        chi_squared=chi_squared,
        df=k - 1,
        p=float(stats.chi2.sf(chi_squared, k - 1)),
        kendall_w=chi_squared / (n * (k - 1)),
    )
