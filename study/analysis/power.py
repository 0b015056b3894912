"""The smallest difference that a paired t test of N participants finds with a given chance."""

from __future__ import annotations

from scipy import optimize, stats

from study.analysis.designs import Untestable
from study.analysis.noncentral_t import below
from study.analysis.wording import ALPHA

POWER = 0.8


def power_of(dz: float, n: int, alpha: float = ALPHA) -> float:
    """Chance that a two-sided paired t test of n participants finds an effect of dz."""
    critical = float(stats.t.ppf(1 - alpha / 2, n - 1))
    ncp = dz * n**0.5
    return 1 - below(critical, n - 1, ncp) + below(-critical, n - 1, ncp)


def detectable_dz(n: int, *, power: float = POWER, alpha: float = ALPHA) -> float:
    """The smallest dz found with this power. Errors: Untestable with fewer than 3 participants."""
    if n < 3:
        raise Untestable(f"with N = {n} no difference worth naming could be found")
    top = 1.0
    while power_of(top, n, alpha) < power:
        top *= 2
    return float(optimize.brentq(lambda dz: power_of(dz, n, alpha) - power, 0.0, top, xtol=1e-10))
