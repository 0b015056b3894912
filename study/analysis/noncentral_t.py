"""The noncentral t distribution, by integrating over the chi distribution of the spread.

SciPy's `nct` returns NaN in parts of its tails, where intervals of effects are looked for.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(600)
_NEGLIGIBLE = 1e-15


def below(t: float, df: int, ncp: float) -> float:
    """Chance that noncentral t of df degrees of freedom and centre ncp is at most t.

    T = (Z + ncp) / S with S = sqrt(chi-squared(df) / df), so it is the mean of Phi(t S - ncp).
    """
    low, high = np.sqrt(stats.chi2.ppf([_NEGLIGIBLE, 1 - _NEGLIGIBLE], df) / df)
    s = (high - low) / 2 * _NODES + (high + low) / 2
    density = stats.chi2.pdf(df * s * s, df) * 2 * df * s
    chance = np.sum(_WEIGHTS * density * stats.norm.cdf(t * s - ncp)) * (high - low) / 2
    return float(np.clip(chance, 0.0, 1.0))
