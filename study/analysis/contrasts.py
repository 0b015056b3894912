"""Paired comparisons of conditions: difference, t test, Cohen's dz with its exact interval."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize, stats

from study.analysis.descriptives import LEVEL, has_spread
from study.analysis.designs import Design, Pairs
from study.analysis.holm import adjust_holm
from study.analysis.noncentral_t import below

WIDEST_T = 100.0


@dataclass(frozen=True)
class PairedComparison:
    """First minus second condition, over participants.

    `p` and `p_holm` are None for pairs that nobody planned; `note` says why something is missing.
    """

    measure: str
    first: str
    second: str
    n: int
    difference: float | None = None
    low: float | None = None
    high: float | None = None
    sd: float | None = None
    t: float | None = None
    df: int | None = None
    p: float | None = None
    p_holm: float | None = None
    dz: float | None = None
    dz_low: float | None = None
    dz_high: float | None = None
    note: str = ""


def compare_pairs(design: Design, pairs: Pairs) -> tuple[PairedComparison, ...]:
    """Compare each pair by a paired t test; p corrected by Holm over the planned pairs."""
    found = [compare_pair(design, first, second) for first, second in pairs.pairs]
    if not pairs.planned:
        return tuple(replace(one, p=None) for one in found)
    corrected = adjust_holm([one.p for one in found])
    return tuple(replace(one, p_holm=p) for one, p in zip(found, corrected, strict=True))


def compare_pair(design: Design, first: str, second: str) -> PairedComparison:
    """Compare two conditions; with fewer than 2 participants, or without spread, say so."""
    differences = design.differences(first, second)
    n = len(differences)
    start = PairedComparison(design.measure, first, second, n)
    if n == 0:
        return replace(start, note="there is no participant with complete data")
    mean = float(differences.mean())
    if n == 1:
        return replace(start, difference=mean, note="one participant has no spread")
    if not has_spread(differences, design.values):
        note = "the difference is the same for every participant"
        return replace(start, difference=mean, sd=0.0, note=note)
    sd = float(differences.std(ddof=1))
    error = sd / n**0.5
    reach = float(stats.t.ppf((1 + LEVEL) / 2, n - 1)) * error
    t = mean / error
    dz_low, dz_high = bound_dz(t, n)
    return replace(
        start,
        difference=mean,
        low=mean - reach,
        high=mean + reach,
        sd=sd,
        t=t,
        df=n - 1,
        p=float(2 * stats.t.sf(abs(t), n - 1)),
        dz=mean / sd,
        dz_low=dz_low,
        dz_high=dz_high,
    )


def bound_dz(t: float, n: int, level: float = LEVEL) -> tuple[float, float]:
    """Interval of dz = t / sqrt(n) by inverting the noncentral t (Cumming and Finch 2001).

    Beyond |t| = 100 by the normal approximation.
    """
    if abs(t) > WIDEST_T:
        reach = float(stats.norm.ppf((1 + level) / 2)) * (1 / n + t * t / n / (2 * n)) ** 0.5
        return t / n**0.5 - reach, t / n**0.5 + reach

    def solve(tail: float) -> float:
        def miss(ncp: float) -> float:
            return below(t, n - 1, ncp) - tail

        reach = 6.0 + abs(t)
        while miss(t - reach) < 0 or miss(t + reach) > 0:
            reach *= 1.5
        return float(optimize.brentq(miss, t - reach, t + reach, xtol=1e-10))

    bounds = solve((1 + level) / 2) / n**0.5, solve((1 - level) / 2) / n**0.5
    return float(np.min(bounds)), float(np.max(bounds))
