"""The tables of the questionnaire, of people and of the figures, computed again."""

from __future__ import annotations

import re
import zlib
from collections import Counter
from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from tests.server.analysis.facts import MEASURES, Facts, Rows, holm, summary

SEED, DRAWS = 20221214, 5000
FAMILY = [f"Q{k}" for k in range(2, 7)]
FIGURES = {"wait": "sum_wait_s", "completion": "sum_completion_s", "slowest": "slowest_robot_s"}


def asked(facts: Facts) -> list[tuple[str, str, str]]:
    """Instrument, item and wording of what is rated after each trial, in the codebook's order."""
    rated = set(facts.responses[facts.responses["condition"] != ""]["instrument"])
    book = facts.codebook[facts.codebook["file"] == "responses.csv"]
    book = book[book["name"].str.contains(".", regex=False)].drop_duplicates("name")
    book = book[book["type"].isin(["scale", "rating", "slider", "number"])]
    parts = book["name"].str.split(".", n=1, expand=True)
    rows = zip(parts[0], parts[1], book["meaning"], strict=True)
    return [(instrument, item, told) for instrument, item, told in rows if instrument in rated]


def questionnaire(facts: Facts) -> dict[str, Rows]:
    """Descriptives, Friedman's test by scipy, Wilcoxon's by counting, Holm by its definition."""
    tables: dict[str, Rows] = {"item_descriptives": [], "friedman": [], "signed_ranks": []}
    for instrument, item, wording in asked(facts):
        table = facts.wide(facts.answers(instrument, item))
        same = {"instrument": instrument, "item": item}
        for name in facts.conditions:
            found = {"wording": wording, "condition": name} | summary(table[name])
            tables["item_descriptives"].append(same | found)
        tables["friedman"].append(same | _friedman(table))
        own = [_signed_ranks(table, pair, f"{instrument}/{item}") for pair in facts.pairs]
        for row, p in zip(own, holm([row["p"] for row in own]), strict=True):
            tables["signed_ranks"].append(same | row | {"p_holm": p})
    for name in ("friedman", "signed_ranks"):
        family = [row for row in tables[name] if row["item"] in FAMILY]
        for row, p in zip(family, holm([row["p"] for row in family]), strict=True):
            row["p_family"] = p
        for row in tables[name]:
            row.setdefault("p_family", np.nan)
    return tables


def _friedman(table: pd.DataFrame) -> dict[str, Any]:
    n, k = table.shape
    with np.errstate(all="ignore"):
        test = stats.friedmanchisquare(*(table[name] for name in table))
    is_tested = bool((table.nunique(axis=1) > 1).any())
    return {"n": n, "chi_squared": test.statistic, "p": test.pvalue,
            "df": k - 1 if is_tested else np.nan, "kendall_w": test.statistic / (n * (k - 1)),
            "note": "" if is_tested else "every participant gave the same value"}  # fmt: skip


def _signed_ranks(table: pd.DataFrame, pair: tuple[str, str], name: str) -> dict[str, Any]:
    first, second = pair
    differences = table[first] - table[second]
    n, used = len(differences), differences != 0
    ranks = differences.abs().rank()
    plus, minus = (float(ranks[side].sum()) for side in (differences > 0, differences < 0))
    seed = zlib.crc32(f"{name}/{first}/{second}".encode(), SEED)
    picks = np.random.default_rng(seed).integers(0, n, (DRAWS, n))
    drawn = differences.to_numpy()[picks]
    effects = (np.sign(drawn) * pd.DataFrame(np.abs(drawn)).rank(axis=1)).sum(axis=1)
    low, high = (effects / (n * (n + 1) / 2)).quantile([0.025, 0.975])
    row = {"first": first, "second": second, "n": n, "zeros": int((~used).sum()),
           "rank_biserial": (plus - minus) / (n * (n + 1) / 2),
           "low": low, "high": high}  # fmt: skip
    assert low <= row["rank_biserial"] <= high
    if not used.any():
        missing = dict.fromkeys(("rank_sum_positive", "rank_sum_negative", "z", "p", "p_normal"))
        return row | dict.fromkeys(missing, np.nan) | {"note": "all answered the same"}
    theirs = stats.wilcoxon(differences, zero_method="pratt", method="asymptotic")
    assert theirs.statistic == min(plus, minus)
    z = (plus - minus) / float((ranks[used] ** 2).sum()) ** 0.5
    return row | {
        "rank_sum_positive": plus, "rank_sum_negative": minus, "z": z, "note": "",
        "p": _count_signs(list(ranks[used]), min(plus, minus)), "p_normal": theirs.pvalue,
    }  # fmt: skip


def _count_signs(ranks: list[float], smaller: float) -> float:
    """The exact two-sided p: the share of all 2^n signs with a rank sum this small, twice."""
    sums = Counter({0.0: 1})
    for rank in ranks:
        sums = sums + Counter({total + rank: ways for total, ways in sums.items()})
    small = sum(ways for total, ways in sums.items() if total <= smaller)
    return min(1.0, float(2 * Fraction(small, 2 ** len(ranks))))


def people(facts: Facts) -> dict[str, Rows]:
    """Counts by status and order, and who is left out of the team measures."""
    whole = set(facts.wide(facts.cases("sum_wait_s")).index)
    placed = facts.people[facts.people["condition_order"] != ""]
    counts = placed.groupby("condition_order")["participant_code"]
    statuses = facts.people["status"].value_counts()
    excluded = [code for code in facts.people["participant_code"] if code not in facts.counted]
    without = [code for code in facts.counted if code not in whole]
    return {
        "statuses": [
            {"status": status, "participants": statuses[status]}
            for status in facts.people["status"].unique()
        ],
        "orders": [
            {"order": order, "shown": order.upper().replace(">", " > "),
             "participants": len(codes), "complete": int(codes.isin(whole).sum())}
            for order, codes in counts
        ],
        "left_out": [{"participant_code": code} for code in (*excluded, *without)],
        "background": _background(facts, whole),
    }  # fmt: skip


def _background(facts: Facts, whole: set[str]) -> Rows:
    """Questions asked once: how often each answer was given; the figures of a number."""
    book = facts.codebook[facts.codebook["file"] == "responses.csv"]
    book = book.drop_duplicates("name").set_index("name")
    given = facts.responses[facts.responses["participant_code"].isin(whole)]
    given = given[(given["condition"] == "") & (given["value"] != "")]
    rows: Rows = []
    for name, entry in book.iterrows():
        instrument, _, item = str(name).partition(".")
        if instrument == "browser_check" or entry["type"] not in ("choice", "number", "scale"):
            continue
        own = given[(given["instrument"] == instrument) & (given["item"] == item)]["value"]
        if own.empty:
            continue
        labels = dict(level.split("=", 1) for level in entry["levels"].split("|") if level)
        answers: list[float] | set[str]
        figures = pd.to_numeric(own, errors="coerce").dropna()
        if entry["type"] == "number" and len(figures):
            answers = [figures.mean(), figures.std(), figures.min(), figures.max(), len(figures)]
            answers += [len(own) - len(figures)] if len(own) > len(figures) else []
        else:
            counts = own.value_counts().items()
            answers = {f"{labels.get(str(value), value)} {n}" for value, n in counts}
        rows.append({"item": name, "wording": entry["meaning"], "answers": answers})
    return rows


def figures(facts: Facts, edges: np.ndarray) -> dict[str, Rows]:
    """What the figures draw; the histogram's edges are the report's choice."""
    tables: dict[str, Rows] = {"figure_wait_histogram": []}
    waits = facts.cases("sum_wait_s")
    width, middle = edges[1] - edges[0], (edges[:-1] + edges[1:]) / 2
    assert np.allclose(np.diff(edges), width)
    assert edges[0] <= waits["value"].min() <= waits["value"].max() <= edges[-1]
    for name in facts.conditions:
        own = waits.loc[waits["condition"] == name, "value"]
        bins = pd.cut(own, edges, right=False, labels=False).value_counts()
        curve = stats.norm.pdf(middle, own.mean(), own.std()) * len(own) * width
        tables["figure_wait_histogram"] += [
            {"group": name, "n": len(own), "mean": own.mean(), "sd": own.std(),
             "bin_low": edges[k], "bin_high": edges[k + 1], "count": bins.get(k, 0),
             "gauss_count": curve[k]}
            for k in range(len(middle))
        ]  # fmt: skip
    for figure, measure in FIGURES.items():
        table = facts.wide(facts.cases(measure))
        tables[f"figure_{figure}_pairs"] = [
            {"participant": code, "condition": name, "value": table.loc[code, name]}
            for code in table.index
            for name in facts.conditions
        ]
    for instrument in dict.fromkeys(instrument for instrument, _, _ in asked(facts)):
        rows = tables["figure_items_" + re.sub(r"\W", "_", instrument)] = []
        for own, item, _ in asked(facts):
            table = facts.wide(facts.answers(own, item))
            for name in facts.conditions if own == instrument else ():
                found = summary(table[name])
                kept = {key: found[key] for key in ("n", "mean", "low", "high")}
                rows.append({"item": item, "condition": name} | kept)
    assert len(MEASURES) == len(FIGURES)
    return tables
