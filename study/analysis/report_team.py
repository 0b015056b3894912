"""The report's part about the team measures as they are: tables, histogram, paired plots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace

from study.analysis.cases import MEASURES, StudyData, label_condition, team_design
from study.analysis.descriptives import summarise
from study.analysis.designs import Design
from study.analysis.histograms import draw_histogram
from study.analysis.paired_lines import draw_pairs
from study.analysis.sheets import Picture, RowsBehind, Section, Sheet, View, make_sheet
from study.analysis.wording import capitalise, mark_title, unformatted

SUMMARY_FIELDS = (
    "n", "mean", "sd", "low", "high", "median", "lower_quartile", "upper_quartile", "smallest",
    "largest",
)  # fmt: skip
SUMMARY_VIEWS = (
    View("N", "plain", ("n",)),
    View("Mean [95 %]", "interval", ("mean", "low", "high")),
    View("SD", "number", ("sd",)),
    View("Median", "plain", ("median",)),
    View("Quartiles", "bounds", ("lower_quartile", "upper_quartile")),
    View("Range", "bounds", ("smallest", "largest")),
)
_NAMES = {"sum_wait_s": "wait", "sum_completion_s": "completion", "slowest_robot_s": "slowest"}


def team_designs(data: StudyData) -> dict[str, Design]:
    """Complete cases of the three team measures."""
    return {measure: team_design(data, measure) for measure in MEASURES}


def rows_of(data: StudyData, design: Design) -> RowsBehind:
    """The trials behind a team measure."""
    return RowsBehind(
        "trials.csv",
        f"{data.mode_filter}, status = completed, participant not excluded and complete in "
        f"{', '.join(design.conditions) or 'no condition'}",
        len(design.readings),
        design.n,
    )


def rows_of_all(data: StudyData, designs: Mapping[str, Design]) -> RowsBehind:
    """The trials behind a table of several measures, by measure where they are not the same."""
    several = [rows_of(data, design) for design in designs.values()]
    people = {design.participants for design in designs.values()}
    if len(people) == 1:
        return several[0]
    everybody = set().union(*people)
    parts = tuple(
        (MEASURES[measure], one.rows, one.participants)
        for measure, one in zip(designs, several, strict=True)
    )
    return replace(
        several[0], rows=sum(one.rows for one in several), participants=len(everybody), parts=parts
    )


def describe_team(data: StudyData, designs: dict[str, Design]) -> Section:
    """Descriptive tables and the paper's histogram; figures only where there is anybody."""
    wait = designs["sum_wait_s"]
    sentences = ["All times are in seconds; intervals are 95 % intervals of the mean (t)."]
    if not wait.n:
        sentences.append("There is no participant with complete data, so there are no figures.")
        return Section("team", "Team measures", tuple(sentences), (_table(data, designs),))
    histogram = draw_histogram(
        {name: wait.column(name) for name in wait.conditions},
        title=mark_title("Total waiting time of all robots per trial", data.mark),
        x_label="total waiting time (s)",
        y_label="trials",
        mark="",
        labels={name: unformatted(label_condition(name)) for name in wait.conditions},
    )
    pictures = [
        Picture(
            "wait_histogram",
            "Histogram of the total waiting time per trial, with the Gaussian curve of each "
            "condition's mean and standard deviation.",
            histogram,
            rows_of(data, wait),
        )
    ]
    pictures += [_pairs(data, design) for design in designs.values() if design.n]
    return Section("team", "Team measures", tuple(sentences), (_table(data, designs), *pictures))


def list_cases(data: StudyData, designs: dict[str, Design]) -> Sheet:
    """Every figure that the team measures' tests used; a file only."""
    rows = [
        {"measure": design.measure, **asdict(reading)}
        for design in designs.values()
        for reading in design.readings
    ]
    header = ("measure", "participant", "condition", "position", "value")
    return make_sheet(
        "cases",
        "Figures used",
        rows,
        header,
        (),
        rows_of_all(data, designs),
    )


def _pairs(data: StudyData, design: Design) -> Picture:
    what = MEASURES[design.measure]
    chart = draw_pairs(design, title=capitalise(what), y_label=f"{what} (s)", mark=data.mark)
    return Picture(
        f"{_NAMES[design.measure]}_pairs",
        f"{capitalise(what)}: a line per participant, diamonds for means with 95 % intervals.",
        chart,
        rows_of(data, design),
        is_small=True,
    )


def _table(data: StudyData, designs: dict[str, Design]) -> Sheet:
    rows = [
        {
            "measure": measure,
            "what": MEASURES[measure],
            "condition": name,
            **asdict(summarise(design.column(name))),
        }
        for measure, design in designs.items()
        for name in design.conditions
    ]
    views = (
        View("Measure", "measure", ("measure",)),
        View("Condition", "quotient", ("condition",)),
        *SUMMARY_VIEWS,
    )
    return make_sheet(
        "team_descriptives",
        "Team measures per condition",
        rows,
        ("measure", "what", "condition", *SUMMARY_FIELDS),
        views,
        rows_of_all(data, designs),
    )
