"""Guards rank tests against printed outputs and against counting by hand."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy import stats

from study.analysis.designs import Floats, Untestable
from study.analysis.friedman import rank_conditions
from study.analysis.signed_ranks import bound_rank_biserial, compare_ranks, rank_biserial
from tests.study.analysis.published import DEPRESSION, ROUNDING, make_design


def count_by_hand(differences: Floats) -> float:
    """Share of all 2^n patterns of signs at least as far from balance as the observed one."""
    ranks = stats.rankdata(abs(differences))
    used = ranks[differences != 0]
    observed = abs((np.sign(differences) * ranks).sum())
    sums = [abs(np.dot(signs, used)) for signs in product((-1, 1), repeat=len(used))]
    return float(np.mean(np.array(sums) >= observed - 1e-9))


def test_wilcoxon_on_the_depression_data() -> None:
    """R's `wilcox.test(x, y, paired = TRUE)`: V = 40, p = 0.03906."""
    found = compare_ranks(DEPRESSION)
    assert (found.rank_sum_positive, found.rank_sum_negative) == (40.0, 5.0)
    assert found.p == pytest.approx(0.0390625)


def test_friedman_on_the_rounding_times() -> None:
    """R's `friedman.test(RoundingTimes)`: chi-squared = 11.143, df = 2, p = 0.003805."""
    found = rank_conditions(ROUNDING)
    assert (found.chi_squared, found.df) == (pytest.approx(11.143, abs=5e-4), 2)
    assert found.p == pytest.approx(0.003805, abs=5e-7)
    assert found.kendall_w == pytest.approx(11.142857 / 44)


@pytest.mark.parametrize("seed", range(6))
def test_zeros_and_ties_as_counted_by_hand(seed: int) -> None:
    """Likert differences: the exact p equals counting all signs; the rest equals SciPy's Pratt."""
    differences = np.random.default_rng(seed).integers(-2, 4, 11).astype(float)
    differences[0], differences[1] = 0.0, 2.0
    found = compare_ranks(differences)
    assert found.p == pytest.approx(count_by_hand(differences))
    theirs = stats.wilcoxon(differences, zero_method="pratt", method="asymptotic")
    assert min(found.rank_sum_positive, found.rank_sum_negative) == theirs.statistic
    assert found.zeros == np.count_nonzero(differences == 0)


def test_the_normal_approximation_is_scipy_s_without_zeros() -> None:
    rng = np.random.default_rng(8)
    differences = rng.normal(0.4, 1, 40)
    theirs = stats.wilcoxon(differences, zero_method="pratt", method="asymptotic")
    found = compare_ranks(differences)
    assert found.p_normal == pytest.approx(theirs.pvalue)
    assert found.p == pytest.approx(stats.wilcoxon(differences, method="exact").pvalue)


def test_a_thousand_participants_take_the_normal_approximation() -> None:
    found = compare_ranks(np.random.default_rng(1).integers(-2, 3, 1000).astype(float))
    assert found.p == found.p_normal


def test_all_ties_cannot_be_tested() -> None:
    with pytest.raises(Untestable, match="all 4 participants answered the same"):
        compare_ranks(np.zeros(4))
    with pytest.raises(Untestable, match="every participant gave the same value"):
        rank_conditions(make_design([[3, 3, 3], [4, 4, 4]], ("a", "b", "c")))


def test_two_conditions_are_not_for_friedman() -> None:
    with pytest.raises(Untestable, match="2 conditions in the data"):
        rank_conditions(make_design([[3, 4], [4, 5]], ("a", "b")))


def test_the_effect_counts_ties_as_no_effect() -> None:
    """Ranks of 0, 1, 2, -3 are 1 to 4: (2 + 3 - 4) / 10."""
    assert rank_biserial(np.array([0.0, 1.0, 2.0, -3.0])) == pytest.approx(0.1)
    assert rank_biserial(np.array([1.0, 2.0, 5.0])) == 1.0
    assert rank_biserial(np.zeros(3)) == 0.0


def test_the_effect_s_interval_is_seeded_and_holds_the_effect() -> None:
    differences = np.random.default_rng(2).integers(-1, 3, 24).astype(float)
    low, high = bound_rank_biserial(differences, 7)
    assert (low, high) == bound_rank_biserial(differences, 7)
    assert (low, high) != bound_rank_biserial(differences, 8)
    assert -1 <= low < rank_biserial(differences) < high <= 1
