"""Guards the tests of a questionnaire's items and the bars drawn from them."""

from __future__ import annotations

import numpy as np
import pytest

from study.analysis.cases import Item, correction_family, read_level, scale_points
from study.analysis.designs import Design, Pairs
from study.analysis.item_bars import ItemScale, draw_items, mark_of
from study.analysis.likert import compare_items, rank_items
from study.analysis.paired_lines import draw_pairs
from tests.study.analysis.published import make_design

NAMES = ("varil", "arroch", "crmiar")
PAIRS = (("varil", "arroch"), ("varil", "crmiar"))
FIVE = tuple((str(k), f"point {k}") for k in range(1, 6))


def item(name: str, instrument: str = "questionnaire") -> Item:
    return Item(instrument, name, "scale", name, FIVE)


def answers(seed: int, shift: float = 0.0) -> Design:
    rng = np.random.default_rng(seed)
    table = rng.integers(2, 5, (20, 3)).astype(float)
    table[:, 0] = np.minimum(5, table[:, 0] + shift)
    return make_design(table.tolist(), NAMES, f"Q{seed}")


def test_q2_to_q6_are_corrected_together() -> None:
    """Q1 stands apart; other instruments take all of their items."""
    items = tuple(item(f"Q{k}") for k in range(1, 7))
    assert correction_family(items, "questionnaire") == ("Q2", "Q3", "Q4", "Q5", "Q6")
    others = (item("effort", "tlx"), item("demand", "tlx"))
    assert correction_family((*items, *others), "tlx") == ("effort", "demand")


def test_corrections_over_contrasts_and_over_the_family() -> None:
    """Holm over 2 within an item; over 10 within the family; Q1 has no family."""
    designs = {item(f"Q{k}"): answers(k, shift=1.0 if k == 4 else 0.0) for k in range(1, 7)}
    found = compare_items(designs, Pairs(PAIRS, planned=True))
    own = [one for one in found if one.item == "Q4"]
    smaller = min(float(one.p or 1) for one in own)
    assert min(float(one.p_holm or 1) for one in own) == pytest.approx(2 * smaller)
    assert min(float(one.p_family or 1) for one in own) == pytest.approx(10 * smaller)
    assert [one.p_family for one in found if one.item == "Q1"] == [None, None]
    ranked = rank_items(designs)
    smallest = min(float(one.p or 1) for one in ranked)
    assert min(float(one.p_family or 1) for one in ranked) == pytest.approx(5 * smallest)


def test_pairs_that_nobody_planned_have_effects_but_no_p_values() -> None:
    found = compare_items({item("Q2"): answers(2)}, Pairs(PAIRS, planned=False))
    assert {(one.p, one.p_holm, one.p_family, one.p_normal) for one in found} == {(None,) * 4}
    assert all(one.rank_biserial is not None for one in found)


def test_answers_are_numbers_or_places_of_levels() -> None:
    low = Item("i", "a", "scale", "", (("never", "Never"), ("often", "Often")))
    assert scale_points(low) == ((1.0, "Never"), (2.0, "Often"))
    assert scale_points(Item("i", "a", "scale", "", (("-1", "No"), ("1", "Yes")))) == (
        (-1.0, "No"),
        (1.0, "Yes"),
    )
    assert read_level("prefer_not_to_say", {"never": 1.0}) is None
    assert read_level("nan", {}) is None


def test_marks_stand_for_corrected_p_values() -> None:
    """The legend's * and **, drawn where they were put."""
    assert [mark_of(p) for p in (None, 0.05, 0.049, 0.01, 0.0099)] == ["", "", "*", "*", "**"]
    chart = draw_items(
        [answers(2), answers(3)],
        {"Q2": {PAIRS[0]: "**", PAIRS[1]: ""}},
        ItemScale(((1.0, "Low $x$"), (5.0, "High")), "marks: ** p < 0.01"),
        title="Answers",
        mark="pilot data",
    )
    text = chart.svg.decode()
    assert text.count(">**<") == 1
    assert all(words in text for words in ("pilot data", "marks: ** p", "Low $x$", "VARIL"))
    means = {(row[0], row[1]): row[3] for row in chart.rows}
    assert means["Q2", "varil"] == pytest.approx(answers(2).column("varil").mean())
    assert len(chart.rows) == 6


@pytest.mark.parametrize("people", [1, 2, 24])
def test_paired_plots_show_everybody(people: int) -> None:
    design = make_design(np.random.default_rng(1).normal(9, 1, (people, 3)).tolist(), NAMES)
    chart = draw_pairs(design, title="Waiting", y_label="s", mark="")
    assert len(chart.rows) == 3 * people
    assert b"ARROCH" in chart.svg
    assert chart.pdf.startswith(b"%PDF")
