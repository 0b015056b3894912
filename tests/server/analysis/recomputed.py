"""Every number of an analysis against the bundle's CSV files, without any code of ours.

`check_analysis` computes all tables again and compares them column by column: a table or column
that nobody computes again fails. What it takes from the report: whether the mixed model or its
fallback was used (and checks that this was right), and the edges of the histogram's bins. Not
computed again: sentences about why somebody was left out, or why something could not be tested.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.server.analysis import recomputed_items, recomputed_team
from tests.server.analysis.facts import Facts, Rows, read_facts

WORDS_ONLY = {("left_out", "reason"), ("friedman", "note"), ("signed_ranks", "note")}
EXACT = 1e-5
COARSE = {"primary_contrasts": 1e-3, "primary_model": 2e-3, "position_ratios": 1e-3}
"""Relative tolerances where two optimisers meet; elsewhere it is `EXACT`."""


def check_analysis(bundle: Path, out: Path, planned: int | None = None) -> Facts:
    """Compare the folder of an analysis with the bundle it was made from."""
    facts, ours = read_facts(bundle), read_tables(out)
    expected = recompute(facts, ours, planned)
    assert set(ours) == set(expected)
    for name, rows in expected.items():
        compare(name, ours[name], rows)
    results = json.loads((out / "results.json").read_text())
    _check_results(results, facts, ours)
    told = "\n".join(results["findings"])
    assert _figures(told) <= _known_figures(ours), _figures(told) - _known_figures(ours)
    return facts


def read_tables(out: Path) -> dict[str, pd.DataFrame]:
    """The analysis' tables by name, cells as text."""
    return {path.stem: _read(path) for path in (out / "tables").glob("*.csv")}


def recompute(facts: Facts, ours: dict[str, pd.DataFrame], planned: int | None) -> dict[str, Rows]:
    """Every table computed again, by name."""
    model = ours["primary_model"].set_index("quantity")["value"]
    is_mixed = bool(model["SD between participants (log)"] != "")
    bins = ours["figure_wait_histogram"]
    edges = np.unique(pd.to_numeric(pd.concat([bins["bin_low"], bins["bin_high"]])).to_numpy())
    return {
        **recomputed_items.people(facts),
        **recomputed_team.describe(facts),
        **recomputed_team.primary(facts, is_mixed=is_mixed),
        **recomputed_team.secondary(facts),
        **recomputed_items.questionnaire(facts),
        "order_tests": recomputed_team.order_effects(facts),
        "detectable": recomputed_team.detectable(facts, planned),
        **recomputed_items.figures(facts, edges),
    }


def _read(path: Path) -> pd.DataFrame:
    return pd.read_csv(path, dtype=str, keep_default_na=False)


def compare(name: str, ours: pd.DataFrame, rows: Rows) -> None:
    """Compare one table with its rows, column by column; AssertionError names the place."""
    assert len(ours) == len(rows), name
    for column in ours:
        if (name, column) in WORDS_ONLY:
            if column == "note":
                filled = [row["note"] != "" for row in rows]
                assert list(ours[column] != "") == filled, (name, column)
            continue
        for place, (cell, row) in enumerate(zip(ours[column], rows, strict=True)):
            where = f"{name}, row {place}, {column}"
            assert column in row, f"{where}: nobody computes this again"
            _compare_cell(cell, row[column], COARSE.get(name, EXACT), where)
    for row in rows:
        assert set(row) - set(ours) <= {"note"}, name


def _compare_cell(cell: str, theirs: Any, tolerance: float, where: str) -> None:
    if isinstance(theirs, list):
        figures = [float(one) for one in re.findall(r"\d+(?:\.\d+)?", cell)]
        assert figures == pytest.approx(theirs, rel=5e-3, abs=5e-4), where
    elif isinstance(theirs, set):
        assert all(part in cell for part in theirs), where
        assert len(cell) == len(", ".join(theirs)), where
    elif isinstance(theirs, str):
        assert cell == theirs, where
    elif pd.isna(theirs):
        assert cell == "", where
    else:
        assert cell != "", where
        near = tolerance / 2 if tolerance > EXACT else 2e-6
        assert float(cell) == pytest.approx(float(theirs), rel=tolerance, abs=near), where


def _check_results(results: dict[str, Any], facts: Facts, ours: dict[str, pd.DataFrame]) -> None:
    """The JSON says what the tables say, and names as many rows as there are."""
    whole = len(facts.wide(facts.cases("sum_wait_s")))
    assert results["participants"] == len(facts.people)
    assert results["excluded"] == len(facts.people) - len(facts.counted)
    assert results["analysed"] == whole
    assert tuple(results["conditions"]) == facts.conditions
    for name, table in results["tables"].items():
        cells = [["" if v is None else str(v) for v in row.values()] for row in table["rows"]]
        assert [list(row) for row in ours[name].to_numpy()] == cells, name
        assert re.search(r": (no row|\d+ rows?) of (no|\d+) participant", table["rows_behind"])
    behind = results["tables"]["primary_contrasts"]["rows_behind"]
    assert behind.endswith(f": {len(facts.cases('sum_wait_s'))} rows of {whole} participants")


def _figures(text: str) -> set[str]:
    """Figures of sentences, as they are written there."""
    return set(re.findall(r"(?<![\w.])\N{MINUS SIGN}?\d+(?:\.\d+)?", text)) - {"95"}


def _known_figures(ours: dict[str, pd.DataFrame]) -> set[str]:
    """Every cell of every table as a sentence may write it."""
    known = {"0.001"}
    for table in ours.values():
        for cell in table.to_numpy().ravel():
            try:
                value = float(cell)
            except ValueError:
                continue
            known |= {f"{value:.{k}f}".replace("-", "\N{MINUS SIGN}") for k in range(5)}
    return known
