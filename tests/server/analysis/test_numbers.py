"""Guards the report's numbers: all recomputed apart from ours with pandas, scipy and statsmodels.

The rehearsal's test does the same with a bundle that a server exported.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from tests.server.analysis.bundles import analyse_bots
from tests.server.analysis.facts import Facts, read_facts
from tests.server.analysis.recomputed import (
    WORDS_ONLY,
    check_analysis,
    compare,
    read_tables,
    recompute,
)

PLANNED = 30


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """24 bots, of whom one is excluded and one lost a trial."""
    return analyse_bots(tmp_path_factory.mktemp("analysis"))


@pytest.fixture(scope="module")
def facts(folder: Path) -> Facts:
    return read_facts(folder / "bots.zip")


def test_every_number_is_what_others_compute_from_the_rows(folder: Path) -> None:
    """All columns of all tables, the JSON, and every figure that a finding names."""
    found = check_analysis(folder / "bots.zip", folder / "out", PLANNED)
    assert (len(found.people), len(found.counted)) == (24, 23)
    assert len(found.wide(found.cases("sum_wait_s"))) == 22
    assert len(found.wide(found.answers("questionnaire", "Q1"))) == 23


def test_a_wrong_number_in_any_column_is_noticed(folder: Path, facts: Facts) -> None:
    """The comparison itself can fail: each column is changed by a twentieth in turn."""
    tables = read_tables(folder / "out")
    expected = recompute(facts, tables, PLANNED)
    changed = 0
    for name, table in tables.items():
        for column in table:
            figures = pd.to_numeric(table[column], errors="coerce")
            place = figures.abs().idxmax() if figures.abs().max() > 1e-3 else None
            if place is None or (name, column) in WORDS_ONLY:
                continue
            wrong = table.copy()
            wrong.loc[place, column] = repr(float(figures[place]) * 1.05)
            with pytest.raises(AssertionError, match=f"{name}, row {place}, {column}"):
                compare(name, wrong, expected[name])
            changed += 1
    assert changed > 120


def test_the_smallest_detectable_difference_by_simulation(folder: Path, facts: Facts) -> None:
    """For the planned N: 80 % power by scipy's t test on drawn samples."""
    row = read_tables(folder / "out")["detectable"].set_index("which").loc["planned"]
    assert row["n"] == str(PLANNED)
    draws = np.random.default_rng(1).normal(float(row["dz_strictest"]), 1, (20_000, PLANNED))
    found = stats.ttest_1samp(draws, 0, axis=1).pvalue < 0.025
    assert found.mean() == pytest.approx(0.8, abs=0.01)


def test_everybody_left_out_is_listed_with_the_reason(folder: Path) -> None:
    left_out = read_tables(folder / "out")["left_out"].set_index("participant_code")["reason"]
    assert left_out["P0005"] == "excluded: no reason given"
    assert "timed_out" in left_out["P0002"]
    assert len(left_out) == 2
