"""The whole report of one mode of one study: sections of sentences, tables and figures.

No clock and no unseeded draw takes part: the same bundle gives the same report.
"""

from __future__ import annotations

from dataclasses import dataclass

from study.analysis.cases import StudyData
from study.analysis.designs import choose_pairs
from study.analysis.mixed import Ratio
from study.analysis.report_items import run_items
from study.analysis.report_order import run_order
from study.analysis.report_parts import word_gaps
from study.analysis.report_people import describe_people
from study.analysis.report_power import describe_power
from study.analysis.report_primary import run_primary
from study.analysis.report_secondary import run_secondary
from study.analysis.report_team import describe_team, list_cases, team_designs
from study.analysis.sheets import Picture, Section, Sheet

_WARNINGS = {
    "pilot": "These are pilot data: they test the study and are no evidence for its hypotheses.",
    "bot": "These participants were simulated: nothing here is evidence about people.",
    "": "There is no participant in these data.",
}


@dataclass(frozen=True)
class Report:
    """What was found. `warning` is empty for live data; `cases` is a table for a file only."""

    study_id: str
    mode: str
    mark: str
    warning: str
    conditions: tuple[str, ...]
    joined: int
    excluded: int
    analysed: int
    findings: tuple[str, ...]
    ratios: tuple[Ratio, ...]
    sections: tuple[Section, ...]
    cases: Sheet

    @property
    def sheets(self) -> tuple[Sheet, ...]:
        """All tables, in the order of the page."""
        shown = (b for section in self.sections for b in section.blocks if isinstance(b, Sheet))
        return (*shown, self.cases)

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """All figures, in the order of the page."""
        return tuple(b for part in self.sections for b in part.blocks if isinstance(b, Picture))


def build_report(data: StudyData, planned_n: int | None = None) -> Report:
    """Analyse a study; tests that the data do not allow become sentences that say why."""
    pairs = choose_pairs(data.conditions)
    designs = team_designs(data)
    primary = run_primary(data, designs["sum_wait_s"], pairs)
    secondary = run_secondary(data, designs, pairs)
    items = run_items(data, pairs)
    order = run_order(data, designs)
    parts = (primary, secondary, items, order)
    return Report(
        study_id=data.study_id,
        mode=data.mode,
        mark=data.mark,
        warning=_WARNINGS.get(data.mode, ""),
        conditions=data.conditions,
        joined=len(data.people),
        excluded=len(data.people) - len(data.counted),
        analysed=designs["sum_wait_s"].n,
        findings=(
            *(told for part in parts for told in part.findings),
            *word_gaps([gap for part in parts for gap in part.gaps]),
        ),
        ratios=primary.ratios,
        sections=(
            describe_people(data),
            describe_team(data, designs),
            primary.section,
            secondary.section,
            items.section,
            order.section,
            describe_power(data, designs, pairs, planned_n),
        ),
        cases=list_cases(data, designs),
    )
