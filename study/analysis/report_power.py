"""The report's part about the smallest differences that a number of participants can show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from study.analysis.cases import MEASURES, StudyData
from study.analysis.descriptives import has_spread
from study.analysis.designs import Design, Pairs, positive_cases
from study.analysis.power import POWER, detectable_dz
from study.analysis.report_team import rows_of_all
from study.analysis.sheets import Section, Sheet, View, make_sheet
from study.analysis.wording import ALPHA, Cell, count, number

HEADING = "Smallest detectable difference"
LADDER = (12, 18, 24, 30, 36, 48, 60)
PRIMARY = "sum_wait_s"


def describe_power(
    data: StudyData, designs: Mapping[str, Design], pairs: Pairs, planned_n: int | None
) -> Section:
    """The smallest differences at 80 % power for the N present, the planned N and a ladder."""
    present = designs[PRIMARY].n
    contrasts = max(1, len(pairs.pairs))
    strictest = ALPHA / contrasts
    used = {**designs, PRIMARY: positive_cases(designs[PRIMARY])}
    spreads = {measure: _spread(design, pairs) for measure, design in used.items()}
    sizes = sorted({*LADDER, *([planned_n] if planned_n else []), *([present] if present else [])})
    rows = []
    for n in sizes:
        if n < 3:
            continue
        strict = detectable_dz(n, alpha=strictest)
        row: dict[str, Cell] = {
            "n": n,
            "which": _which(n, present, planned_n),
            "dz": detectable_dz(n),
            "dz_strictest": strict,
        }
        for measure, spread in spreads.items():
            row[measure] = None if spread is None else strict * spread
        in_logs = row[PRIMARY]
        row[PRIMARY] = None if in_logs is None else float(np.exp(-float(in_logs)))
        rows.append(row)
    how = (
        f"What a paired t test, two-sided, finds with {100 * POWER:.0f} % power (noncentral t), as "
        f"Cohen's dz at p < {ALPHA} and at p < {number(strictest)}, the strictest step of Holm's "
        f"correction over {count(contrasts, 'contrast')}. The other columns translate the latter "
        "by the spread of the paired differences in these data (root mean square over the "
        "contrasts): a ratio of waiting times, and seconds."
    )
    unplanned = "No planned number of participants was given (option --planned)."
    sentences = (how,) if planned_n else (how, unplanned)
    return Section("power", HEADING, sentences, (_sheet(data, used, rows),))


def _which(n: int, present: int, planned_n: int | None) -> str:
    return " and ".join(
        word for word, own in (("planned", planned_n), ("present", present)) if own == n
    )


def _spread(design: Design, pairs: Pairs) -> float | None:
    """Root mean square over pairs of the differences' SD; of logarithms for the primary one."""
    if design.n < 2 or not pairs.pairs:
        return None
    if design.measure == PRIMARY:
        design = replace(design, values=np.log(design.values))
    found = [design.differences(*pair) for pair in pairs.pairs]
    if not any(has_spread(one, design.values) for one in found):
        return None
    return float(np.sqrt(np.mean([np.var(one, ddof=1) for one in found])))


def _sheet(data: StudyData, designs: Mapping[str, Design], rows: list[dict[str, Cell]]) -> Sheet:
    views = (
        View("N", "plain", ("n",)),
        View("Which", "text", ("which",)),
        View("dz", "number", ("dz",)),
        View("dz (Holm)", "number", ("dz_strictest",)),
        View("Waiting time, ratio", "number", ("sum_wait_s",)),
        View("Completion times, s", "number", ("sum_completion_s",)),
        View("Slowest robot, s", "number", ("slowest_robot_s",)),
    )
    header = ("n", "which", "dz", "dz_strictest", *MEASURES)
    title = "Smallest difference found with 80 % power"
    return make_sheet("detectable", title, rows, header, views, rows_of_all(data, designs))
