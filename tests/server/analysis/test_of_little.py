"""Guards the analysis of little: few people, missing trials, constant data, other conditions."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from server.analysis.run import AnalysisOptions, analyze
from tests.server.analysis.bundles import Bundle, make_bundle


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are put together but not printed, which takes most of an analysis' time."""
    empty = b"<svg></svg>"
    monkeypatch.setattr("study.analysis.drawing._print", lambda figure, form, metadata: empty)


def analysed(tmp_path: Path, bundle: Bundle) -> tuple[dict[str, Any], str]:
    path = bundle.write(tmp_path / "a.zip")
    summary = analyze(AnalysisOptions(path, tmp_path / "out"))
    return summary, (tmp_path / "out/report.html").read_text()


@pytest.mark.parametrize(
    ("people", "sentence"),
    [
        (0, "there is no participant with complete data, and at least 2 are needed"),
        (1, "there is 1 participant with complete data, and at least 2 are needed"),
        (2, "Total waiting time under VARIL was"),
    ],
)
def test_few_participants_get_a_report_and_reasons(
    people: int, sentence: str, tmp_path: Path
) -> None:
    summary, text = analysed(tmp_path, make_bundle(people))
    assert summary["analysed"] == people
    assert any(sentence in finding for finding in summary["findings"])
    assert sentence.split(",")[0] in text


@pytest.mark.usefixtures("undrawn")
def test_constant_data_and_ties_are_told_apart_from_no_difference(tmp_path: Path) -> None:
    bundle = make_bundle(5)
    for row in bundle.tables["trials"]:
        row |= dict.fromkeys(("sum_wait_s", "sum_completion_s", "slowest_robot_s"), "100.0")
    for row in bundle.tables["responses"]:
        row["value"] = "3" if row["condition"] else row["value"]
    summary, text = analysed(tmp_path, bundle)
    told = " ".join(summary["findings"])
    assert "nothing varies within participants" in told
    assert "the differences between conditions are the same for every participant" in told
    assert "all 5 participants answered the same in both conditions" in told
    assert ">nan" not in text.lower()


@pytest.mark.usefixtures("undrawn")
def test_missing_trials_leave_the_participant_out(tmp_path: Path) -> None:
    """A trial away, one without a figure: each measure counts whom it can, and names its rows."""
    bundle = make_bundle(6)
    bundle.tables["trials"][3]["sum_wait_s"] = ""
    del bundle.tables["trials"][0]
    summary, text = analysed(tmp_path, bundle)
    assert summary["analysed"] == 4
    assert "no trial" in text
    assert "trial 1 has no sum_wait_s" in text
    rows = pd.read_csv(tmp_path / "out/tables/anova.csv")
    assert list(rows["n"]) == [5, 5]
    tables = json.loads((tmp_path / "out/results.json").read_text())["tables"]
    assert tables["team_descriptives"]["rows_behind"].endswith(
        ": 12 rows of 4 participants for the total waiting time; "
        "15 rows of 5 participants for the sum of completion times; "
        "15 rows of 5 participants for the time of the slowest robot"
    )
    assert tables["anova"]["rows_behind"].endswith(": 15 rows of 5 participants")
    assert tables["primary_contrasts"]["rows_behind"].endswith(": 12 rows of 4 participants")


@pytest.mark.usefixtures("undrawn")
def test_a_wait_of_zero_costs_one_participant_not_the_analysis(tmp_path: Path) -> None:
    bundle = make_bundle(6)
    bundle.tables["trials"][0]["sum_wait_s"] = "0.0"
    summary, text = analysed(tmp_path, bundle)
    assert summary["analysed"] == 6
    assert "a value of 0 has no logarithm: P0000" in text
    assert pd.read_csv(tmp_path / "out/tables/primary_contrasts.csv")["n"].eq(5).all()
    power = pd.read_csv(tmp_path / "out/tables/detectable.csv")
    assert power["sum_wait_s"].between(0, 1, inclusive="neither").all()
    tables = json.loads((tmp_path / "out/results.json").read_text())["tables"]
    for name in ("order_tests", "detectable"):
        behind = tables[name]["rows_behind"]
        assert ": 15 rows of 5 participants for the total waiting time; 18 rows of 6" in behind
    assert tables["position_ratios"]["rows_behind"].endswith(": 15 rows of 5 participants")


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    "conditions",
    [
        ("varil",),
        ("varil", "none"),
        ("arroch", "crmiar", "none"),
        ("varil", "arroch", "crmiar", "none", "full"),
    ],
)
def test_one_to_five_conditions(conditions: tuple[str, ...], tmp_path: Path) -> None:
    """Planned contrasts start from `varil`; without it pairs carry no p-value."""
    summary, text = analysed(tmp_path, make_bundle(8, conditions=conditions))
    assert set(summary["conditions"]) == set(conditions)
    if len(conditions) < 2:
        assert "there is 1 condition in the data, and at least 2 are needed" in text
        return
    rows = pd.read_csv(tmp_path / "out/tables/primary_contrasts.csv")
    assert len(rows) == (3 if "varil" not in conditions else len(conditions) - 1)
    assert rows["p"].isna().all() == ("varil" not in conditions)
    assert ("without p-values" in text) == ("varil" not in conditions)
