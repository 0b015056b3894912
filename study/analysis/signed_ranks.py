"""Wilcoxon's signed-rank test with Pratt's treatment of zeros, exact, and its effect size.

Pratt (1959): differences of zero take part in the ranking and are dropped afterwards. The p-value
is exact given the ranks, ties included: every sign of every non-zero difference is as likely as
the other. Effect: matched-pairs rank-biserial correlation (Kerby 2014) = (favourable rank sum -
unfavourable rank sum) / sum of all ranks, those of zeros included, so ties count as no effect.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from study.analysis.descriptives import LEVEL
from study.analysis.designs import Floats, Untestable
from study.analysis.wording import count

DRAWS = 5000
EXACT_UP_TO = 400
_AT_ONCE = 2_000_000


@dataclass(frozen=True)
class SignedRanks:
    """The test of one pair; `p_normal` is the usual normal approximation, for comparison."""

    n: int
    zeros: int
    rank_sum_positive: float
    rank_sum_negative: float
    p: float
    p_normal: float
    z: float


def compare_ranks(differences: Floats) -> SignedRanks:
    """Test whether float64[n] differences lie symmetrically about 0, two-sided.

    Errors: Untestable if there is no difference other than zero.
    """
    n = len(differences)
    if not np.count_nonzero(differences):
        raise Untestable(
            f"all {n} participants answered the same in both conditions"
            if n > 1
            else f"{count(n, 'participant')} with a difference"
        )
    ranks = stats.rankdata(np.abs(differences))
    positive = float(ranks[differences > 0].sum())
    negative = float(ranks[differences < 0].sum())
    used = ranks[differences != 0]
    z = (positive - negative) / float(np.sum(used**2)) ** 0.5
    p_normal = float(2 * stats.norm.sf(abs(z)))
    p = exact_tail(used, min(positive, negative)) if n <= EXACT_UP_TO else p_normal
    return SignedRanks(n, int(n - len(used)), positive, negative, p, p_normal, z)


def exact_tail(ranks: Floats, smaller: float) -> float:
    """Two-sided chance that a rank sum is as small as `smaller`, over all 2^n signs.

    Ranks are whole or half numbers; their doubles are added up by convolution.
    """
    doubled = np.rint(2 * ranks).astype(np.int64)
    chances = np.zeros(int(doubled.sum()) + 1)
    chances[0] = 1.0
    for step in doubled:
        moved = np.zeros_like(chances)
        moved[step:] = chances[: len(chances) - step]
        chances = (chances + moved) / 2
    return min(1.0, 2 * float(chances[: round(2 * smaller) + 1].sum()))


def rank_biserial(differences: Floats) -> float:
    """Effect in -1..1 of float64[..., n] differences, n >= 1; 0 if all are zero."""
    return float(_rank_biserial(differences[np.newaxis, :])[0])


def bound_rank_biserial(
    differences: Floats, seed: int, *, draws: int = DRAWS, level: float = LEVEL
) -> tuple[float, float]:
    """Percentile interval of the effect from `draws` resamples of the participants."""
    generator = np.random.default_rng(seed)
    n = len(differences)
    found = np.empty(draws)
    block = max(1, _AT_ONCE // n)
    for start in range(0, draws, block):
        picks = generator.integers(0, n, (min(block, draws - start), n))
        found[start : start + len(picks)] = _rank_biserial(differences[picks])
    low, high = np.quantile(found, [(1 - level) / 2, (1 + level) / 2])
    return float(low), float(high)


def _rank_biserial(rows: Floats) -> Floats:
    ranks = stats.rankdata(np.abs(rows), axis=1)
    n = rows.shape[1]
    return np.asarray(np.sum(np.sign(rows) * ranks, axis=1) / (n * (n + 1) / 2), np.float64)
