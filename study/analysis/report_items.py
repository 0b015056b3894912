"""The report's part about the questionnaires that follow every trial."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields

from study.analysis.cases import (
    SCORE,
    Item,
    StudyData,
    correction_family,
    item_design,
    label_condition,
    scale_points,
)
from study.analysis.descriptives import summarise
from study.analysis.designs import Design, Pairs
from study.analysis.item_bars import ItemScale, draw_items, mark_of
from study.analysis.likert import SEED, ItemPair, ItemRanking, compare_items, rank_items
from study.analysis.report_parts import Gap, Tested, note_plan, word_gaps
from study.analysis.report_team import SUMMARY_FIELDS, SUMMARY_VIEWS
from study.analysis.sheets import Picture, RowsBehind, Section, Sheet, View, make_sheet
from study.analysis.wording import ALPHA, equals, interval, number, unformatted

HEADING = "Questionnaire"
LEGEND = "* p < 0.05, ** p < 0.01 (Wilcoxon signed-rank, Holm over the planned contrasts)"
WHISKERS = "Whiskers: 95 % interval of the mean."


def run_items(data: StudyData, pairs: Pairs) -> Tested:
    """Friedman's test per item, Wilcoxon's per item and planned contrast, and the bars."""
    if not data.rated_items:
        gap = Gap("questionnaire", "no item was answered after a trial")
        return Tested(Section("items", HEADING, (), (), word_gaps([gap])), (), (gap,))
    designs = {item: item_design(data, item) for item in data.rated_items}
    ranked, compared = rank_items(designs), compare_items(designs, pairs)
    tested = [(one, one.p_holm) for one in compared if one.p_holm is not None]
    findings = _word_ranking(ranked)
    findings += [_word_pair(one) for one, p in tested if p < ALPHA]
    if tested and not any(p < ALPHA for _, p in tested):
        findings.append("No planned contrast showed a difference on any item.")
    gaps = [Gap(f"{one.item}, all conditions", one.note) for one in ranked if one.note]
    gaps += [Gap(_name(one), one.note) for one in compared if one.note]
    sentences = (_describe_tests(data), *note_plan(pairs))
    blocks: list[Sheet | Picture] = [_describe(data, designs)]
    if any(one.p is not None for one in ranked):
        blocks.append(_ranking_sheet(data, designs, ranked))
    if compared:
        blocks.append(_pair_sheet(data, designs, compared))
    blocks += [
        _draw(data, instrument, designs, compared)
        for instrument in dict.fromkeys(item.instrument for item in designs)
        if _drawn(designs, instrument)
    ]
    section = Section("items", HEADING, sentences, tuple(blocks), (*findings, *word_gaps(gaps)))
    return Tested(section, tuple(findings), tuple(gaps))


def _describe_tests(data: StudyData) -> str:
    families = "; ".join(
        f"{', '.join(correction_family(data.rated_items, name))} of {name}"
        for name in dict.fromkeys(item.instrument for item in data.rated_items)
    )
    return (
        "Friedman's test over all conditions per item with Kendall's W, then Wilcoxon's "
        "signed-rank test with Pratt's treatment of zeros (exact, given the ranks), corrected by "
        "Holm over the planned contrasts of an item, and in a further column over all items of a "
        f"family ({families}). The effect r is the matched-pairs rank-biserial correlation; ties "
        "count as no effect; its interval is a percentile bootstrap over participants "
        f"(seed {SEED})."
    )


def _word_ranking(ranked: Sequence[ItemRanking]) -> list[str]:
    """One sentence for Friedman's tests of all items; none if there was none."""
    tested = [one for one in ranked if one.p is not None]
    if not tested:
        return []
    found = [one for one in tested if one.p is not None and one.p < ALPHA]
    if not found:
        return ["Answers to no item differed between conditions (Friedman's test)."]
    told = ", ".join(
        f"{one.item} (χ²({one.df}) = {number(one.chi_squared)}, p {equals(one.p)}, "
        f"W = {number(one.kendall_w)})"
        for one in found
    )
    return [f"Answers differed between conditions (Friedman's test) on {told}."]


def _name(one: ItemPair) -> str:
    return f"{one.item}, {label_condition(one.first)} − {label_condition(one.second)}"


def _word_pair(one: ItemPair) -> str:
    higher = (one.rank_biserial or 0.0) > 0
    family = f"; over the family p {equals(one.p_family)}" if one.p_family is not None else ""
    return (
        f"{one.item}: {label_condition(one.first)} rated {'higher' if higher else 'lower'} than "
        f"{label_condition(one.second)} (p {equals(one.p_holm)} after Holm{family}; "
        f"r = {interval((one.rank_biserial, one.low, one.high))})."
    )


def _behind(data: StudyData, designs: Mapping[Item, Design]) -> RowsBehind:
    names = ", ".join(dict.fromkeys(item.instrument for item in designs))
    people = {code for design in designs.values() for code in design.participants}
    return RowsBehind(
        "responses.csv",
        f"{data.mode_filter}, instrument = {names}, participant not excluded and with an answer "
        "in every condition (per item)",
        sum(len(design.readings) for design in designs.values()),
        len(people),
    )


def _item_view(designs: Mapping[Item, Design]) -> View:
    """The column that names the item, and its instrument where there are several."""
    several = len({item.instrument for item in designs}) > 1
    return View("Item", "text", ("instrument", "item") if several else ("item",))


def _describe(data: StudyData, designs: Mapping[Item, Design]) -> Sheet:
    rows = [
        {
            "instrument": item.instrument,
            "item": item.name,
            "wording": item.wording,
            "condition": name,
            **asdict(summarise(design.column(name))),
        }
        for item, design in designs.items()
        for name in design.conditions
    ]
    header = ("instrument", "item", "wording", "condition", *SUMMARY_FIELDS)
    views = (_item_view(designs), View("Condition", "quotient", ("condition",)), *SUMMARY_VIEWS)
    title = "Answers per item and condition"
    return make_sheet("item_descriptives", title, rows, header, views, _behind(data, designs))


def _ranking_sheet(
    data: StudyData, designs: Mapping[Item, Design], ranked: Sequence[ItemRanking]
) -> Sheet:
    views = (
        _item_view(designs),
        View("N", "plain", ("n",)),
        View("χ²", "number", ("chi_squared",)),
        View("df", "plain", ("df",)),
        View("p", "p", ("p",)),
        View("p (family)", "p", ("p_family",)),
        View("Kendall's W", "number", ("kendall_w",)),
    )
    header = tuple(field.name for field in fields(ItemRanking))
    title = "All conditions: Friedman's test"
    rows = [asdict(one) for one in ranked]
    return make_sheet("friedman", title, rows, header, views, _behind(data, designs))


def _pair_sheet(
    data: StudyData, designs: Mapping[Item, Design], compared: Sequence[ItemPair]
) -> Sheet:
    views = (
        _item_view(designs),
        View("Contrast", "difference", ("first", "second")),
        View("N", "plain", ("n",)),
        View("Ties", "plain", ("zeros",)),
        View("Rank sums +, −", "list", ("rank_sum_positive", "rank_sum_negative")),
        View("p", "p", ("p",)),
        View("p (Holm)", "p", ("p_holm",)),
        View("p (family)", "p", ("p_family",)),
        View("r [95 %]", "interval", ("rank_biserial", "low", "high")),
    )
    header = tuple(field.name for field in fields(ItemPair))
    title = "Contrasts: Wilcoxon's signed-rank test"
    rows = [asdict(one) for one in compared]
    return make_sheet("signed_ranks", title, rows, header, views, _behind(data, designs))


def _drawn(designs: Mapping[Item, Design], instrument: str) -> dict[Item, Design]:
    """The instrument's items that have bars; a score is on a scale of its own."""
    return {
        item: design
        for item, design in designs.items()
        if item.instrument == instrument and item.kind != SCORE and design.n
    }


def _draw(
    data: StudyData,
    instrument: str,
    designs: Mapping[Item, Design],
    compared: Sequence[ItemPair],
) -> Picture:
    own = {
        i: d for i, d in designs.items() if i.instrument == instrument and d.n and i.kind != SCORE
    }
    marks: dict[str, dict[tuple[str, str], str]] = {}
    for one in compared:
        if one.instrument == instrument:
            marks.setdefault(one.item, {})[one.first, one.second] = mark_of(one.p_holm)
    scales = {scale_points(item) for item in own}
    points = scales.pop() if len(scales) == 1 else ()
    chart = draw_items(
        list(own.values()),
        marks,
        ItemScale(points, LEGEND),
        title=f"Answers after each trial: {unformatted(instrument)}",
        mark=data.mark,
    )
    wordings = " ".join(f"{item.name}: {item.wording}" for item in own)
    caption = f"Mean answer per item and condition. {WHISKERS} {wordings}"
    return Picture("items_" + re.sub(r"\W", "_", instrument), caption, chart, _behind(data, own))
