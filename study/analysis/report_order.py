"""The report's part about order and carry-over."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, fields

import numpy as np

from study.analysis.cases import MEASURES, StudyData
from study.analysis.descriptives import summarise
from study.analysis.designs import Design, Untestable, positive_cases
from study.analysis.mixed import Ratio, compare_positions, fit_log_model
from study.analysis.order_effects import NestedTest, check_carry_over, check_position
from study.analysis.report_parts import Gap, Tested, attempt, word_gaps
from study.analysis.report_team import SUMMARY_FIELDS, SUMMARY_VIEWS, rows_of, rows_of_all
from study.analysis.sheets import Section, Sheet, View, make_sheet
from study.analysis.wording import ALPHA, capitalise, equals, number

HEADING = "Order and carry-over"
PRIMARY = "sum_wait_s"
_RATIO_FIELDS = ("first", "second", "ratio", "low", "high", "t", "df", "p")


def run_order(data: StudyData, designs: Mapping[str, Design]) -> Tested:
    """Did the position matter, or the condition met before? By measure."""
    found: list[NestedTest] = []
    findings: list[str] = []
    gaps: list[Gap] = []
    tested = {**designs, PRIMARY: positive_cases(designs[PRIMARY])}
    for measure, design in tested.items():
        for check in (check_position, check_carry_over):
            one, missing = _check(measure, design, check)
            gaps += missing
            found += [one] if one else []
            findings += [_word(one)] if one and one.p < ALPHA else []
    if found and not any(one.p < ALPHA for one in found):
        findings.insert(0, "No effect of position or of the previous condition was shown.")
    how = (
        "F tests of what position, and beyond it the previous condition, explain within "
        "participants (least squares; total waiting time in logarithms). These tests look for "
        "flaws of the design and are not corrected for their number."
    )
    blocks: list[Sheet] = []
    if designs[PRIMARY].n:
        blocks.append(_positions(data, designs))
    if found:
        blocks.append(_tests(data, tested, found))
    if ratios := _ratios(tested[PRIMARY]):
        blocks.append(_ratio_sheet(data, tested[PRIMARY], ratios))
    told = (*findings, *word_gaps(gaps))
    section = Section("order", HEADING, (how,), tuple(blocks), told)
    return Tested(section, tuple(findings), tuple(gaps))


def _check(
    measure: str, design: Design, check: Callable[..., NestedTest]
) -> tuple[NestedTest | None, list[Gap]]:
    what = "position" if check is check_position else "carry-over"
    return attempt(
        f"{MEASURES[measure]}, {what}",
        lambda: check(design, logarithms=measure == PRIMARY),
    )


def _word(one: NestedTest) -> str:
    return (
        f"{capitalise(MEASURES[one.measure])}: {one.what} mattered, "
        f"F({one.df}, {one.df_error}) = {number(one.f)}, p {equals(one.p)}, "
        f"partial η² = {number(one.partial_eta_squared)}."
    )


def _ratios(design: Design) -> tuple[Ratio, ...]:
    try:
        return compare_positions(fit_log_model(design))
    except Untestable:
        return ()


def _positions(data: StudyData, designs: Mapping[str, Design]) -> Sheet:
    rows = []
    for measure, design in designs.items():
        for position in sorted({reading.position for reading in design.readings}):
            values = [one.value for one in design.readings if one.position == position]
            found = asdict(summarise(np.array(values, np.float64)))
            rows.append(
                {"measure": measure, "what": MEASURES[measure], "position": position} | found
            )
    views = (
        View("Measure", "measure", ("measure",)),
        View("Position", "plain", ("position",)),
        *SUMMARY_VIEWS,
    )
    return make_sheet(
        "positions",
        "Team measures per position",
        rows,
        ("measure", "what", "position", *SUMMARY_FIELDS),
        views,
        rows_of_all(data, designs),
    )


def _tests(data: StudyData, designs: Mapping[str, Design], found: list[NestedTest]) -> Sheet:
    views = (
        View("Measure", "measure", ("measure",)),
        View("Effect", "text", ("what",)),
        View("Scale", "text", ("scale",)),
        View("N", "plain", ("n",)),
        View("F", "number", ("f",)),
        View("df", "list", ("df", "df_error")),
        View("p", "p", ("p",)),
        View("partial η²", "number", ("partial_eta_squared",)),
    )
    header = tuple(field.name for field in fields(NestedTest))
    rows = [asdict(one) for one in found]
    title = "Position and previous condition"
    return make_sheet("order_tests", title, rows, header, views, rows_of_all(data, designs))


def _ratio_sheet(data: StudyData, design: Design, ratios: tuple[Ratio, ...]) -> Sheet:
    views = (
        View("Positions", "quotient", ("first", "second")),
        View("Ratio [95 %]", "interval", ("ratio", "low", "high")),
        View("t", "number", ("t",)),
        View("df", "plain", ("df",)),
        View("p", "p", ("p",)),
    )
    rows = [asdict(one) for one in ratios]
    title = "Total waiting time: later positions against the first (primary model)"
    return make_sheet("position_ratios", title, rows, _RATIO_FIELDS, views, rows_of(data, design))
