"""Guards the report's numbers: recomputed apart from ours with pandas, scipy and statsmodels."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from statsmodels.formula.api import mixedlm
from statsmodels.stats.anova import AnovaRM

from tests.server.analysis.bundles import analyse_bots

OTHERS = ("arroch", "crmiar")
Tables = dict[str, pd.DataFrame]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """24 bots, of whom one is excluded and one lost a trial."""
    return analyse_bots(tmp_path_factory.mktemp("analysis"))


@pytest.fixture(scope="module")
def trials(folder: Path) -> pd.DataFrame:
    """Complete cases, found with pandas."""
    frame = read_rows(folder, "trials.csv")
    frame = frame[(frame["participant_code"] != "P0005") & (frame["status"] == "completed")]
    whole = frame.groupby("participant_code")["condition"].transform("size") == 3
    frame = frame[whole].copy()
    for name in ("sum_wait_s", "sum_completion_s", "slowest_robot_s", "position"):
        frame[name] = pd.to_numeric(frame[name])
    assert frame["participant_code"].nunique() == 22
    return frame


@pytest.fixture(scope="module")
def tables(folder: Path) -> Tables:
    return {path.stem: pd.read_csv(path) for path in (folder / "out/tables").glob("*.csv")}


def read_rows(folder: Path, name: str) -> pd.DataFrame:
    with zipfile.ZipFile(folder / "bots.zip") as archive:
        return pd.DataFrame(csv.DictReader(io.StringIO(archive.read(name).decode())))


def wide(trials: pd.DataFrame, measure: str) -> pd.DataFrame:
    return trials.pivot_table(index="participant_code", columns="condition", values=measure)


def test_descriptive_numbers(trials: pd.DataFrame, tables: Tables) -> None:
    """Mean, SD, quartiles and interval of every measure and condition, by pandas and scipy."""
    assert len(tables["team_descriptives"]) == 9
    for row in tables["team_descriptives"].itertuples():
        values = trials.loc[trials["condition"] == row.condition, row.measure]
        low, high = stats.t.interval(0.95, 21, values.mean(), values.sem())
        theirs = [values.mean(), values.std(), low, high, *values.quantile([0.25, 0.5, 0.75])]
        ours = [row.mean, row.sd, row.low, row.high]
        ours += [row.lower_quartile, row.median, row.upper_quartile]
        assert (row.n, ours) == (22, pytest.approx(theirs))


@pytest.mark.filterwarnings("ignore:The MLE may be on the boundary")
def test_the_primary_contrasts(trials: pd.DataFrame, tables: Tables) -> None:
    """The formula interface of statsmodels gives the same estimates and standard errors."""
    model = mixedlm(
        "np.log(sum_wait_s) ~ C(condition, Treatment('varil')) + C(position)",
        trials,
        groups="participant_code",
    ).fit(method="powell")
    p_values = []
    for name, row in zip(OTHERS, tables["primary_contrasts"].itertuples(), strict=True):
        key = f"C(condition, Treatment('varil'))[T.{name}]"
        estimate, error = -model.params[key], model.bse[key]
        assert (row.second, row.df) == (name, 66 - 22 - 2 - 2)
        assert row.ratio == pytest.approx(np.exp(estimate), rel=1e-4)
        assert row.standard_error == pytest.approx(error, rel=1e-3)
        reach = stats.t.ppf(0.975, 40) * error
        assert row.low == pytest.approx(np.exp(estimate - reach), rel=1e-3)
        p_values.append(2 * stats.t.sf(abs(estimate / error), 40))
    larger, smaller = max(p_values), min(p_values)
    expected = [max(2 * smaller, larger) if p == larger else 2 * smaller for p in p_values]
    assert list(tables["primary_contrasts"]["p_holm"]) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("measure", ["sum_completion_s", "slowest_robot_s"])
def test_the_secondary_tests(measure: str, trials: pd.DataFrame, tables: Tables) -> None:
    """F by statsmodels' AnovaRM, epsilon by its definition, t by scipy."""
    (row,) = tables["anova"][tables["anova"]["measure"] == measure].itertuples()
    theirs = AnovaRM(trials, measure, "participant_code", within=["condition"]).fit().anova_table
    assert row.f == pytest.approx(theirs["F Value"].iloc[0])
    assert row.p_uncorrected == pytest.approx(theirs["Pr > F"].iloc[0])
    table = wide(trials, measure)
    center = np.eye(3) - 1 / 3
    spread = center @ np.cov(table.to_numpy().T) @ center
    epsilon = np.trace(spread) ** 2 / (2 * np.sum(spread**2))
    assert row.greenhouse_geisser == pytest.approx(epsilon)
    assert row.p == pytest.approx(stats.f.sf(row.f, 2 * epsilon, 42 * epsilon))
    own = tables["paired_contrasts"][tables["paired_contrasts"]["measure"] == measure]
    for name, pair in zip(OTHERS, own.itertuples(), strict=True):
        test = stats.ttest_rel(table["varil"], table[name])
        interval = test.confidence_interval()
        assert (pair.t, pair.p) == pytest.approx((test.statistic, test.pvalue))
        assert (pair.low, pair.high) == pytest.approx((interval.low, interval.high))
        assert pair.dz == pytest.approx(test.statistic / 22**0.5)


def test_the_questionnaire(folder: Path, tables: Tables) -> None:
    """Friedman by scipy, Wilcoxon's sums and normal approximation by scipy; 23 answered all."""
    answers = read_rows(folder, "responses.csv")
    answers = answers[
        (answers["instrument"] == "questionnaire") & (answers["participant_code"] != "P0005")
    ].copy()
    answers["value"] = pd.to_numeric(answers["value"])
    for item in (f"Q{k}" for k in range(1, 7)):
        table = wide(answers[answers["item"] == item], "value")
        (row,) = tables["friedman"][tables["friedman"]["item"] == item].itertuples()
        test = stats.friedmanchisquare(*(table[name] for name in table))
        assert (row.n, row.p) == (23, pytest.approx(test.pvalue))
        assert row.kendall_w == pytest.approx(test.statistic / 46)
        own = tables["signed_ranks"][tables["signed_ranks"]["item"] == item]
        for name, pair in zip(OTHERS, own.itertuples(), strict=True):
            differences = table["varil"] - table[name]
            theirs = stats.wilcoxon(differences, zero_method="pratt", method="asymptotic")
            sums = (pair.rank_sum_positive, pair.rank_sum_negative)
            assert (min(sums), pair.p_normal) == pytest.approx((theirs.statistic, theirs.pvalue))
            assert pair.rank_biserial == pytest.approx((sums[0] - sums[1]) / (23 * 24 / 2))
            assert pair.low <= pair.rank_biserial <= pair.high
        small, large = sorted(own["p"])
        holm = [2 * small, max(2 * small, large)]
        assert sorted(own["p_holm"]) == pytest.approx(np.minimum(1, holm))
    family = tables["signed_ranks"].set_index("item")["p_family"]
    assert family.loc["Q1"].isna().all()
    assert family.loc["Q2":"Q6"].notna().all()


def test_the_smallest_detectable_difference(trials: pd.DataFrame, tables: Tables) -> None:
    """For the planned N: 80 % power by simulation of scipy's paired t test."""
    row = tables["detectable"].set_index("which").loc["planned"]
    table = wide(trials, "sum_completion_s")
    spread = np.mean([np.var(table["varil"] - table[name], ddof=1) for name in OTHERS]) ** 0.5
    assert row["n"] == 30
    assert row["sum_completion_s"] == pytest.approx(row["dz_strictest"] * spread)
    draws = np.random.default_rng(1).normal(row["dz_strictest"], 1, (20_000, 30))
    found = stats.ttest_1samp(draws, 0, axis=1).pvalue < 0.025
    assert found.mean() == pytest.approx(0.8, abs=0.01)
    assert tables["detectable"]["which"].eq("present").sum() == 1


def test_everybody_left_out_is_listed(folder: Path, tables: Tables) -> None:
    left_out = tables["left_out"].set_index("participant_code")["reason"]
    assert left_out["P0005"] == "excluded: no reason given"
    assert "timed_out" in left_out["P0002"]
    assert len(left_out) == 2
    results = json.loads((folder / "out/results.json").read_text())
    assert (results["participants"], results["excluded"], results["analysed"]) == (24, 1, 22)
    behind = results["tables"]["primary_contrasts"]["rows_behind"]
    assert behind.endswith("66 rows of 22 participants")
