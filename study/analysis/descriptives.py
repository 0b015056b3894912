"""What a sample looks like before anything is tested."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from study.analysis.designs import Floats

LEVEL = 0.95


@dataclass(frozen=True)
class Summary:
    """N, mean with its t interval, standard deviation (n - 1), quartiles (R's type 7), range.

    What a sample is too small for is None.
    """

    n: int
    mean: float | None = None
    sd: float | None = None
    low: float | None = None
    high: float | None = None
    median: float | None = None
    lower_quartile: float | None = None
    upper_quartile: float | None = None
    smallest: float | None = None
    largest: float | None = None


def summarise(values: Floats, level: float = LEVEL) -> Summary:
    """Describe a sample float64[n]; one value has no spread and no interval."""
    n = len(values)
    if n == 0:
        return Summary(0)
    mean = float(np.mean(values))
    sd = low = high = None
    if n > 1:
        sd = float(np.std(values, ddof=1))
        reach = float(stats.t.ppf((1 + level) / 2, n - 1)) * sd / n**0.5
        low, high = mean - reach, mean + reach
    smallest, lower, median, upper, largest = (
        float(value) for value in np.quantile(values, [0, 0.25, 0.5, 0.75, 1])
    )
    return Summary(n, mean, sd, low, high, median, lower, upper, smallest, largest)


def has_spread(values: Floats, of: Floats) -> bool:
    """Whether values differ by more than rounding; `of` are the numbers they were computed from."""
    if len(values) < 2:
        return False
    return bool(np.ptp(values) > 1e-10 * float(np.max(np.abs(of))))
