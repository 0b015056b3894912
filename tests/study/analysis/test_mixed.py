"""Guards the primary model against a published fit, and its fallbacks."""

from __future__ import annotations

import numpy as np
import pytest

from study.analysis.anova import analyse_variance
from study.analysis.designs import Design, Pairs, Reading, Untestable, complete_cases
from study.analysis.mixed import (
    adjusted_means,
    compare_conditions,
    compare_positions,
    fit_log_model,
)
from study.analysis.order_effects import check_carry_over, check_position
from tests.study.analysis.published import STOOLS, make_design

NAMES = ("varil", "arroch", "crmiar")
ORDERS = ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))
PLANNED = Pairs((("varil", "arroch"), ("varil", "crmiar")), planned=True)


def counterbalanced(
    people: int, noise: float, person: float, position: float = 0.0, carry: float = 0.0
) -> Design:
    """Log-normal times; `varil` is 20 % shorter; later positions and a first `arroch` cost."""
    rng = np.random.default_rng(11)
    readings = []
    for k in range(people):
        level, order = 7 + person * rng.normal(), ORDERS[k % 6]
        for place, index in enumerate(order):
            shift = position * place + carry * (place > 0 and order[place - 1] == 1)
            log = level + (np.log(0.8) if index == 0 else 0) + shift + noise * rng.normal()
            readings.append(Reading(f"P{k:02}", NAMES[index], place + 1, float(np.exp(log))))
    return complete_cases(
        "sum_wait_s", readings, NAMES, sorted({r.participant for r in readings}), {}
    )


def exponentials(design: Design) -> Design:
    return make_design(np.exp(design.values).tolist(), design.conditions)


def test_the_stools_of_pinheiro_and_bates() -> None:
    """`summary(lme(effort ~ Type, ergoStool, ~ 1 | Subject))`, put in as exponentials.

    Printed: effects 3.889, 2.222, 0.667 with standard error 0.519 on 24 degrees of freedom,
    standard deviations 1.332 between people and 1.100 within, p of T4 = 0.211.
    """
    model = fit_log_model(exponentials(STOOLS), with_position=False)
    assert (model.method, model.df, model.rows) == ("mixed", 24, 36)
    assert model.coefficients == pytest.approx([8.5556, 3.8889, 2.2222, 0.6667], abs=5e-5)
    assert model.participant_sd == pytest.approx(1.3325, abs=5e-4)
    assert model.residual_sd == pytest.approx(1.1003, abs=5e-4)
    found = compare_conditions(model, Pairs((("T2", "T1"), ("T4", "T1")), planned=True))
    assert found[0].standard_error == pytest.approx(0.5187, abs=5e-4)
    assert found[0].t == pytest.approx(7.498, abs=5e-3)
    assert found[1].p == pytest.approx(0.2110, abs=5e-4)
    assert found[1].p_holm == found[1].p


def test_balanced_contrasts_equal_those_of_the_analysis_of_variance() -> None:
    """Without position a contrast's variance is 2 MS(error) / N."""
    design = counterbalanced(24, noise=0.2, person=0.3)
    model = fit_log_model(design, with_position=False)
    logs = make_design(np.log(design.values).tolist(), NAMES)
    anova = analyse_variance(logs)
    ratio = compare_conditions(model, PLANNED)[0]
    assert ratio.log_difference == pytest.approx(logs.differences("varil", "arroch").mean())
    rest = logs.values - logs.values.mean(0) - logs.values.mean(1, keepdims=True)
    error = float(((rest + logs.values.mean()) ** 2).sum()) / anova.df_error
    assert ratio.standard_error == pytest.approx((2 * error / 24) ** 0.5, rel=1e-3)
    assert ratio.df == anova.df_error


def test_the_model_finds_the_ratio_that_was_put_in() -> None:
    design = counterbalanced(24, noise=0.1, person=0.3, position=-0.1)
    model = fit_log_model(design)
    assert model.with_position
    for ratio in compare_conditions(model, PLANNED):
        assert ratio.low < 0.8 < ratio.high
        assert ratio.p_holm is not None
        assert ratio.p_holm < 0.001
    second, third = compare_positions(model)
    assert second.ratio == pytest.approx(np.exp(-0.1), abs=0.05)
    assert third.ratio == pytest.approx(np.exp(-0.2), abs=0.05)
    means = adjusted_means(model, NAMES)
    assert means["varil"] / means["arroch"] == pytest.approx(
        compare_conditions(model, PLANNED)[0].ratio
    )
    assert means["crmiar"] == pytest.approx(np.exp(np.log(design.values[:, 2]).mean()), rel=1e-6)


def test_a_singular_fit_falls_back_to_fixed_participants() -> None:
    """Participants who do not differ put the intercepts' variance at zero; estimates stay."""
    rng = np.random.default_rng(3)
    table = rng.normal(7, 0.2, (12, 3))
    table -= table.mean(axis=1, keepdims=True) - 7
    design = make_design(np.exp(table).tolist(), NAMES)
    model = fit_log_model(design, with_position=False)
    assert model.method == "fixed"
    assert "singular" in model.reason
    ratio = compare_conditions(model, PLANNED)[0]
    assert ratio.log_difference == pytest.approx((table[:, 0] - table[:, 1]).mean())
    assert adjusted_means(model, NAMES)["varil"] == pytest.approx(np.exp(table[:, 0].mean()))


def test_one_order_for_all_leaves_position_out() -> None:
    """Position and condition cannot be told apart then; the result says so."""
    rng = np.random.default_rng(4)
    design = make_design(np.exp(rng.normal(7, 0.3, (8, 3))).tolist(), NAMES)
    model = fit_log_model(design)
    assert not model.with_position
    assert "cannot be told apart" in model.note
    assert compare_positions(model) == ()
    with pytest.raises(Untestable, match="position cannot be told apart"):
        check_position(design, logarithms=True)


def test_what_has_no_logarithm_is_refused() -> None:
    with pytest.raises(Untestable, match="no logarithm"):
        fit_log_model(make_design([[0, 1, 2], [3, 4, 5]], NAMES))


@pytest.mark.parametrize("people", [2, 3])
def test_very_few_participants_give_a_result_or_a_reason(people: int) -> None:
    model = fit_log_model(counterbalanced(people, noise=0.2, person=0.3))
    assert all(ratio.low < ratio.ratio < ratio.high for ratio in compare_conditions(model, PLANNED))


def test_constant_data_are_refused() -> None:
    with pytest.raises(Untestable, match="nothing varies"):
        fit_log_model(make_design([[5, 5, 5]] * 4, NAMES))


def test_order_and_carry_over_are_found_where_they_are() -> None:
    none = counterbalanced(24, noise=0.1, person=0.3)
    assert check_position(none, logarithms=True).p > 0.05
    assert check_carry_over(none, logarithms=True).p > 0.05
    both = counterbalanced(24, noise=0.1, person=0.3, position=-0.15, carry=0.2)
    position = check_position(both, logarithms=True)
    assert position.p < 0.001
    assert (position.df, position.df_error) == (2, 72 - 24 - 2 - 2)
    carry = check_carry_over(both, logarithms=False)
    assert carry.p < 0.001
    assert (carry.df, carry.df_error) == (2, 72 - 24 - 2 - 2 - 2)


@pytest.mark.filterwarnings("ignore:The design matrix is rank-deficient")
def test_the_position_test_equals_statsmodels_table() -> None:
    """F of `anova_lm` between the two formulas, fitted apart from our matrices."""
    import pandas as pd
    from statsmodels.formula.api import ols
    from statsmodels.stats.anova import anova_lm

    design = counterbalanced(12, noise=0.2, person=0.3, position=0.1, carry=0.1)
    frame = pd.DataFrame([vars(reading) for reading in design.readings])
    frame["previous"] = frame.sort_values("position").groupby("participant")["condition"].shift()
    frame["previous"] = frame["previous"].fillna("none")
    base = "np.log(value) ~ C(participant) + C(condition)"
    models = [
        ols(base + more, frame).fit()
        for more in ("", " + C(position)", " + C(position) + C(previous)")
    ]
    table = anova_lm(*models[:2])
    ours = check_position(design, logarithms=True)
    assert (ours.f, ours.p) == pytest.approx((table["F"][1], table["Pr(>F)"][1]))
    ours = check_carry_over(design, logarithms=True)
    assert (ours.df, ours.df_error) == (2, int(models[1].df_resid) - 2)
    assert ours.f == pytest.approx(
        ((models[1].ssr - models[2].ssr) / 2) / (models[2].ssr / ours.df_error)
    )
