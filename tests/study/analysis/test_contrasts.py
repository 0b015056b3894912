"""Guards paired comparisons, Holm's correction and the smallest detectable difference."""

from __future__ import annotations

import pytest
from scipy import stats

from study.analysis.contrasts import bound_dz, compare_pair, compare_pairs
from study.analysis.designs import Pairs, Untestable, choose_pairs
from study.analysis.holm import adjust_holm
from study.analysis.noncentral_t import below
from study.analysis.power import detectable_dz, power_of
from tests.study.analysis.published import SLEEP, make_design


def test_student_s_sleep_data() -> None:
    """R's `t.test(paired = TRUE)` on `sleep`; dz and its interval as `effectsize` prints them."""
    found = compare_pair(SLEEP, "drug 1", "drug 2")
    assert (found.t, found.df, found.p) == (
        pytest.approx(-4.0621, abs=5e-5),
        9,
        pytest.approx(0.002833, abs=5e-7),
    )
    assert (found.low, found.difference, found.high) == pytest.approx(
        (-2.4598858, -1.58, -0.7001142), abs=5e-8
    )
    assert (found.dz, found.dz_low, found.dz_high) == pytest.approx((-1.28, -2.12, -0.41), abs=5e-3)


@pytest.mark.parametrize(("t", "n"), [(0.0, 5), (2.5, 12), (-8.0, 24), (25.0, 60)])
def test_the_interval_of_dz_turns_the_noncentral_t_round(t: float, n: int) -> None:
    """At its bounds the observed t has a chance of 2.5 % on either side."""
    low, high = bound_dz(t, n)
    assert 1 - below(t, n - 1, low * n**0.5) == pytest.approx(0.025, abs=1e-8)
    assert below(t, n - 1, high * n**0.5) == pytest.approx(0.025, abs=1e-8)


@pytest.mark.parametrize("df", [1, 2, 7, 23, 500])
def test_the_noncentral_t_equals_scipy_s_where_that_has_a_value(df: int) -> None:
    """And the central t, whose values are beyond doubt."""
    for t in (-3.0, 0.5, 2.0):
        assert below(t, df, 0.0) == pytest.approx(stats.t.cdf(t, df), abs=1e-10)
        assert below(t, df, 1.5) == pytest.approx(stats.nct.cdf(t, df, 1.5), abs=1e-8)


def test_an_enormous_t_has_bounds_around_it() -> None:
    low, high = bound_dz(400.0, 25)
    assert low < 80.0 < high


def test_holm_as_in_r() -> None:
    """`p.adjust(c(0.01, 0.02, 0.03, 0.005), "holm")`, out of order and with a missing test."""
    assert adjust_holm([0.01, None, 0.02, 0.03, 0.005]) == pytest.approx(
        (0.03, None, 0.04, 0.04, 0.02)
    )
    assert adjust_holm([0.7, 0.6]) == (1.0, 1.0)
    assert adjust_holm([]) == ()


def test_only_planned_pairs_carry_p_values() -> None:
    """Comparisons that nobody planned are described, never tested."""
    planned = compare_pairs(SLEEP, Pairs((("drug 1", "drug 2"),), planned=True))
    other = compare_pairs(SLEEP, Pairs((("drug 1", "drug 2"),), planned=False))
    assert planned[0].p_holm == planned[0].p is not None
    assert (other[0].p, other[0].p_holm) == (None, None)
    assert other[0].low == planned[0].low


def test_pairs_follow_from_the_conditions() -> None:
    assert choose_pairs(("varil", "arroch", "crmiar")) == Pairs(
        (("varil", "arroch"), ("varil", "crmiar")), planned=True
    )
    assert choose_pairs(("arroch", "full", "none")) == Pairs(
        (("arroch", "full"), ("arroch", "none"), ("full", "none")), planned=False
    )
    assert choose_pairs(("varil",)).pairs == ()


@pytest.mark.parametrize(
    ("table", "note"),
    [
        ([], "no participant"),
        ([[1.0, 2.0]], "one participant"),
        ([[1.0, 2.0], [2.0, 3.0]], "the same for every participant"),
    ],
)
def test_pairs_without_a_test_say_why(table: list[list[float]], note: str) -> None:
    found = compare_pair(make_design(table, ("a", "b")), "a", "b")
    assert note in found.note
    assert found.p is None


def test_power_as_g_power_tells_it() -> None:
    """dz = 0.5, alpha = .05, power = .80 needs 34 participants (actual power 0.8078)."""
    assert power_of(0.5, 34) == pytest.approx(0.8078, abs=5e-5)
    assert power_of(0.5, 33) < 0.8


@pytest.mark.parametrize("n", [3, 12, 24, 200])
def test_the_detectable_difference_is_found_with_the_wanted_power(n: int) -> None:
    assert power_of(detectable_dz(n), n) == pytest.approx(0.8)
    assert detectable_dz(n, alpha=0.025) > detectable_dz(n)


def test_two_participants_detect_nothing() -> None:
    with pytest.raises(Untestable, match="N = 2"):
        detectable_dz(2)
