"""The report's secondary analyses: completion times, as the paper's, and the slowest robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial

from study.analysis.anova import Anova, analyse_variance
from study.analysis.cases import MEASURES, StudyData, label_condition
from study.analysis.contrasts import PairedComparison, compare_pairs
from study.analysis.designs import Design, Pairs
from study.analysis.report_parts import Gap, Tested, attempt, note_plan, word_gaps
from study.analysis.report_team import rows_of_all
from study.analysis.sheets import Section, Sheet, View, make_sheet
from study.analysis.wording import capitalise, equals, interval, number, verdict

SECONDARY = ("sum_completion_s", "slowest_robot_s")
_PAIR_FIELDS = (
    "measure", "first", "second", "n", "difference", "low", "high", "sd", "t", "df", "p", "p_holm",
    "dz", "dz_low", "dz_high", "note",
)  # fmt: skip
_ANOVA_FIELDS = (
    "measure", "n", "f", "df_conditions", "df_error", "df_conditions_corrected",
    "df_error_corrected", "p", "p_uncorrected", "p_huynh_feldt", "partial_eta_squared",
    "generalised_eta_squared", "mauchly_w", "chi_squared", "df", "mauchly_p",
    "greenhouse_geisser", "huynh_feldt",
)  # fmt: skip


def run_secondary(data: StudyData, designs: dict[str, Design], pairs: Pairs) -> Tested:
    """Analysis of variance and paired t tests of the paper's measure and of the slowest robot."""
    anovas: list[Anova] = []
    compared: list[PairedComparison] = []
    findings: list[str] = []
    gaps: list[Gap] = []
    for measure in SECONDARY:
        design, what = designs[measure], MEASURES[measure]
        found, missing = attempt(what, partial(analyse_variance, design))
        gaps += missing
        anovas += [found] if found else []
        findings += [_word_anova(found)] if found else []
        compared += compare_pairs(design, pairs) if len(design.conditions) > 1 else ()
    findings += [_word_pair(one) for one in compared if one.t is not None and pairs.planned]
    gaps += [Gap(_name(one), one.note) for one in compared if one.note]
    how = (
        "The paper tests the sum of completion times and calls the slowest robot's time the "
        "team's. Repeated-measures analysis of variance with Greenhouse-Geisser's correction, "
        "then paired t tests with Holm's correction over the planned contrasts of each measure."
    )
    sentences = (how, *note_plan(pairs))
    tested = {measure: designs[measure] for measure in SECONDARY}
    blocks: list[Sheet] = []
    if anovas:
        blocks.append(_anova_sheet(data, tested, anovas))
    if compared:
        blocks.append(_pair_sheet(data, tested, compared))
    section = Section(
        "secondary",
        "Secondary analyses: completion times and the slowest robot",
        sentences,
        tuple(blocks),
        (*findings, *word_gaps(gaps)),
    )
    return Tested(section, tuple(findings), tuple(gaps))


def _word_anova(found: Anova) -> str:
    what = MEASURES[found.measure]
    freedom = f"{number(found.df_conditions_corrected)}, {number(found.df_error_corrected)}"
    return (
        f"{capitalise(what)}, all conditions: F({freedom}) = {number(found.f)}, "
        f"p {equals(found.p)}, generalised η² = {number(found.generalised_eta_squared)}: "
        f"{verdict(found.p)}."
    )


def _name(one: PairedComparison) -> str:
    pair = f"{label_condition(one.first)} minus {label_condition(one.second)}"
    return f"{MEASURES[one.measure]}, {pair}"


def _word_pair(one: PairedComparison) -> str:
    return (
        f"{capitalise(_name(one))}: {interval((one.difference, one.low, one.high))} s, "
        f"t({one.df}) = {number(one.t)}, p {equals(one.p_holm)} after Holm, "
        f"dz = {interval((one.dz, one.dz_low, one.dz_high))}: {verdict(one.p_holm)}."
    )


def _anova_sheet(data: StudyData, designs: Mapping[str, Design], anovas: Sequence[Anova]) -> Sheet:
    rows = []
    for anova in anovas:
        shape = asdict(anova.sphericity)
        mauchly_p = shape.pop("p")
        rows.append(asdict(anova) | shape | {"mauchly_p": mauchly_p})
    views = (
        View("Measure", "measure", ("measure",)),
        View("N", "plain", ("n",)),
        View("F", "number", ("f",)),
        View("df", "list", ("df_conditions", "df_error")),
        View("Mauchly W", "number", ("mauchly_w",)),
        View("p (Mauchly)", "p", ("mauchly_p",)),
        View("ε (GG)", "number", ("greenhouse_geisser",)),
        View("ε (HF)", "number", ("huynh_feldt",)),
        View("p (GG)", "p", ("p",)),
        View("partial η²", "number", ("partial_eta_squared",)),
        View("general. η²", "number", ("generalised_eta_squared",)),
    )
    return make_sheet(
        "anova",
        "Repeated-measures analysis of variance",
        rows,
        _ANOVA_FIELDS,
        views,
        rows_of_all(data, designs),
    )


def _pair_sheet(
    data: StudyData, designs: Mapping[str, Design], compared: Sequence[PairedComparison]
) -> Sheet:
    views = (
        View("Measure", "measure", ("measure",)),
        View("Contrast", "difference", ("first", "second")),
        View("N", "plain", ("n",)),
        View("Difference s [95 %]", "interval", ("difference", "low", "high")),
        View("t", "number", ("t",)),
        View("df", "plain", ("df",)),
        View("p", "p", ("p",)),
        View("p (Holm)", "p", ("p_holm",)),
        View("dz [95 %]", "interval", ("dz", "dz_low", "dz_high")),
    )
    return make_sheet(
        "paired_contrasts",
        "Paired comparisons",
        [asdict(one) for one in compared],
        _PAIR_FIELDS,
        views,
        rows_of_all(data, designs),
    )
