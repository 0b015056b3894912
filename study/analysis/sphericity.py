"""Sphericity of repeated measures: Mauchly's test and the corrections of the degrees of freedom.

Sources: Mauchly (1940) with the second-order term of Box (1949) and Anderson (2003, 10.7.4), as in
R's `mauchly.test`; Greenhouse and Geisser (1959); Huynh and Feldt (1976).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg, stats

from study.analysis.designs import Floats


@dataclass(frozen=True)
class Sphericity:
    """Mauchly's W with its test, and the two epsilons; None where the data allow no test."""

    greenhouse_geisser: float
    huynh_feldt: float
    mauchly_w: float | None = None
    chi_squared: float | None = None
    df: int | None = None
    p: float | None = None


def measure_sphericity(values: Floats) -> Sphericity:
    """Examine float64[participants n, conditions k], n >= 2 and k >= 2.

    With k = 2 sphericity cannot fail (both epsilons are 1). Mauchly's test needs n > k - 1.
    """
    n, k = values.shape
    if k == 2:
        return Sphericity(1.0, 1.0)
    contrasts = linalg.helmert(k)
    spread = contrasts @ np.cov(values, rowvar=False) @ contrasts.T
    d = k - 1
    trace = float(np.trace(spread))
    squared = float(np.sum(spread * spread))
    if squared == 0:
        return Sphericity(1.0, 1.0)
    gg = min(1.0, max(1 / d, trace**2 / (d * squared)))
    below = d * (n - 1 - d * gg)
    hf = min(1.0, max(gg, (n * d * gg - 2) / below)) if below > 0 else 1.0
    w = float(np.linalg.det(spread)) / (trace / d) ** d
    if n - 1 < d or w <= 0:
        return Sphericity(gg, hf)
    return Sphericity(gg, hf, *_test_mauchly(w, d, n - 1))


def _test_mauchly(w: float, d: int, freedom: int) -> tuple[float, float, int, float]:
    rho = 1 - (2 * d * d + d + 2) / (6 * d * freedom)
    second = (
        (d + 2) * (d - 1) * (d - 2) * (2 * d**3 + 6 * d**2 + 3 * d + 2)
        / (288 * (freedom * d * rho) ** 2)
    )  # fmt: skip
    chi_squared = max(0.0, -freedom * rho * float(np.log(w)))
    df = d * (d + 1) // 2 - 1
    p = float(stats.chi2.sf(chi_squared, df))
    p += second * (float(stats.chi2.sf(chi_squared, df + 4)) - p)
    return w, chi_squared, df, min(1.0, max(0.0, p))
