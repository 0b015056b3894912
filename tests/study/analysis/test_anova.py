"""Guards analysis of variance and its corrections against published outputs."""

from __future__ import annotations

import numpy as np
import pytest

from study.analysis.anova import analyse_variance
from study.analysis.designs import Untestable
from study.analysis.sphericity import measure_sphericity
from tests.study.analysis.published import BUSHTUCKER, STOOLS, make_design


def test_the_textbook_example_of_field() -> None:
    """SPSS's table as printed by Field: W, both epsilons, F and all three p-values."""
    found = analyse_variance(BUSHTUCKER)
    assert found.f == pytest.approx(3.794, abs=5e-4)
    assert (found.df_conditions, found.df_error) == (3, 21)
    shape = found.sphericity
    assert shape.mauchly_w == pytest.approx(0.136, abs=5e-4)
    assert shape.chi_squared == pytest.approx(11.406, abs=5e-4)
    assert (shape.df, shape.p) == (5, pytest.approx(0.047, abs=5e-4))
    assert shape.greenhouse_geisser == pytest.approx(0.533, abs=5e-4)
    assert shape.huynh_feldt == pytest.approx(0.666, abs=5e-4)
    assert found.df_conditions_corrected == pytest.approx(1.599, abs=5e-4)
    assert found.df_error_corrected == pytest.approx(11.190, abs=5e-4)
    p_values = (found.p_uncorrected, found.p, found.p_huynh_feldt)
    assert p_values == pytest.approx((0.026, 0.063, 0.048), abs=5e-4)
    assert found.partial_eta_squared == pytest.approx(0.351, abs=5e-4)  # 83.125 / 236.5


def test_the_stools_of_pinheiro_and_bates() -> None:
    """`anova(lme(effort ~ Type, ergoStool, ~ 1 | Subject))`: F(3, 24) = 22.36, p < .0001."""
    found = analyse_variance(STOOLS)
    assert found.f == pytest.approx(22.3556, abs=5e-5)
    assert (found.df_conditions, found.df_error) == (3, 24)
    assert found.p_uncorrected == pytest.approx(3.935e-7, rel=1e-3)


def test_two_conditions_equal_the_paired_t_test() -> None:
    """With two conditions F is t squared, and nothing needs correcting."""
    rng = np.random.default_rng(5)
    design = make_design(rng.normal(10, 2, (9, 2)).tolist(), ("a", "b"))
    found = analyse_variance(design)
    difference = design.differences("a", "b")
    t = difference.mean() / (difference.std(ddof=1) / 3)
    assert found.f == pytest.approx(t**2)
    assert found.p == found.p_uncorrected == found.p_huynh_feldt
    assert found.sphericity.mauchly_w is None


def test_epsilon_lies_between_its_bounds() -> None:
    """1 / (k - 1) for one direction of variation, 1 for compound symmetry."""
    line = np.outer(np.arange(6.0), [1.0, 2.0, 3.0, 5.0])
    assert measure_sphericity(line).greenhouse_geisser == pytest.approx(1 / 3)
    round_ = np.eye(4) * 3 + 7
    assert measure_sphericity(round_).greenhouse_geisser == pytest.approx(1.0)


def test_fewer_participants_than_conditions_get_no_test_of_mauchly() -> None:
    design = make_design([[1, 2, 4, 9], [2, 2, 3, 1], [5, 1, 2, 2]], ("a", "b", "c", "d"))
    found = analyse_variance(design)
    assert found.sphericity.p is None
    assert 0 < found.p <= 1


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ([], "no participant with complete data"),
        ([[1.0, 2.0]], "1 participant with complete data"),
        ([[5.0, 5.0], [5.0, 5.0], [5.0, 5.0]], "the same for every participant"),
        ([[1000.1, 1001.2], [999.1, 1000.2], [3000.7, 3001.8]], "the same for every participant"),
    ],
)
def test_what_cannot_be_tested_says_why(table: list[list[float]], sentence: str) -> None:
    """Too few people, constant data, and differences equal but for rounding."""
    with pytest.raises(Untestable, match=sentence):
        analyse_variance(make_design(table, ("a", "b")))
