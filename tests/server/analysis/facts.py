"""What a bundle's CSV files say, read with pandas alone: the start of every recomputed number."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

MEASURES = {
    "sum_wait_s": "total waiting time",
    "sum_completion_s": "sum of completion times",
    "slowest_robot_s": "time of the slowest robot",
}
Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class Facts:
    """Tables of text, the conditions with `varil` first, and the codes of those who count."""

    people: pd.DataFrame
    trials: pd.DataFrame
    responses: pd.DataFrame
    codebook: pd.DataFrame
    conditions: tuple[str, ...]
    counted: tuple[str, ...]

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """The planned contrasts."""
        return [("varil", name) for name in self.conditions[1:]]

    def cases(self, measure: str) -> pd.DataFrame:
        """Complete cases of a team measure, a row per trial, in the file's order."""
        rows = self.trials[self.trials["participant_code"].isin(self.counted)]
        rows = rows[(rows["status"] == "completed") & (rows[measure] != "")]
        return self._complete(rows.assign(value=pd.to_numeric(rows[measure])))

    def answers(self, instrument: str, item: str) -> pd.DataFrame:
        """Complete cases of an item that is asked after each trial."""
        rows = self.responses
        rows = rows[(rows["instrument"] == instrument) & (rows["item"] == item)]
        rows = rows[rows["participant_code"].isin(self.counted)]
        return self._complete(rows.assign(value=pd.to_numeric(rows["value"])))

    def _complete(self, rows: pd.DataFrame) -> pd.DataFrame:
        met = rows.groupby("participant_code")["condition"].transform("nunique")
        kept = rows[met == len(self.conditions)].copy()
        kept["position"] = pd.to_numeric(kept["position"])
        return kept

    def wide(self, rows: pd.DataFrame) -> pd.DataFrame:
        """A row per participant in the order of participants.csv, a column per condition."""
        table = rows.pivot_table(index="participant_code", columns="condition", values="value")
        table = table.reindex(columns=list(self.conditions))
        return table.reindex([code for code in self.counted if code in table.index])


def read_facts(bundle: Path) -> Facts:
    """The facts of a bundle of one mode."""
    with zipfile.ZipFile(bundle) as archive:
        people, trials, responses, quality, codebook = (
            _read(archive, name)
            for name in ("participants", "trials", "responses", "quality", "codebook")
        )
    orders = [name for order in people["condition_order"] for name in order.split(">") if name]
    names = set(orders) | set(trials["condition"])
    conditions = tuple(sorted(names, key=lambda name: (name != "varil", name)))
    assert (quality["flags"] == "").all()
    counted = people[(people["status"] != "excluded") & (people["flags"] == "")]
    codes = tuple(counted["participant_code"])
    return Facts(people, trials, responses, codebook, conditions, codes)


def _read(archive: zipfile.ZipFile, name: str) -> pd.DataFrame:
    text = io.StringIO(archive.read(f"{name}.csv").decode(), newline="")
    lines = csv.reader(text)
    header = next(lines)
    return pd.DataFrame(list(lines), columns=header)


def summary(values: pd.Series[float] | Sequence[float]) -> dict[str, Any]:
    """N, mean, SD, t interval, quartiles and range, by pandas and scipy."""
    one = pd.Series(values)
    low, high = stats.t.interval(0.95, len(one) - 1, one.mean(), one.sem())
    if one.std() == 0:
        low = high = one.mean()
    lower, middle, upper = one.quantile([0.25, 0.5, 0.75])
    return {
        "n": len(one), "mean": one.mean(), "sd": one.std(), "low": low, "high": high,
        "median": middle, "lower_quartile": lower, "upper_quartile": upper,
        "smallest": one.min(), "largest": one.max(),
    }  # fmt: skip


def holm(p_values: Sequence[float]) -> list[float]:
    """Holm's correction by its definition; NaN (no test) takes no part and stays."""
    p = np.asarray(p_values, float)
    out, known = np.full(len(p), np.nan), np.flatnonzero(~np.isnan(p))
    ordered = known[np.argsort(p[known], kind="stable")]
    factors = len(known) - np.arange(len(known))
    out[ordered] = np.minimum(1.0, np.maximum.accumulate(p[ordered] * factors))
    return [float(one) for one in out]
