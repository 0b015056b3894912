"""Paired plots: a line per participant over the conditions, with means and their intervals."""

from __future__ import annotations

import numpy as np

from study.analysis.cases import label_condition
from study.analysis.descriptives import summarise
from study.analysis.designs import Design
from study.analysis.drawing import INK, SOFT, Chart, finish_chart, new_figure, style_of
from study.analysis.wording import mark_title, unformatted

ASIDE = 0.13
HEADER = ("participant", "condition", "value")


def draw_pairs(design: Design, *, title: str, y_label: str, mark: str) -> Chart:
    """Draw every participant's values, one line each; the design has at least one participant.

    Rows: one per participant and condition.
    """
    figure, (axis,) = new_figure(3.5, 3.6)
    places = range(len(design.conditions))
    faint = max(0.15, min(0.6, 20 / design.n))
    gap = np.full((design.n, 1), np.nan)  # all lines are one, with breaks: quick for thousands
    along = np.broadcast_to(np.array([*places, np.nan]), (design.n, len(places) + 1))
    axis.plot(
        along.ravel(), np.hstack([design.values, gap]).ravel(), color=SOFT, alpha=faint,
        linewidth=0.8, marker="o", markersize=2,
    )  # fmt: skip
    for place, name in zip(places, design.conditions, strict=True):
        style, found = style_of(name, place), summarise(design.column(name))
        low, mean, high = found.low, float(found.mean or 0.0), found.high
        reach = [[mean - low], [high - mean]] if low is not None and high is not None else None
        axis.errorbar(
            [place + ASIDE], [mean], yerr=reach, color=style.colour, marker="D", markersize=6,
            capsize=4, linewidth=1.8, zorder=5, markeredgecolor="white",
        )  # fmt: skip
    axis.set_xticks(
        list(places), [unformatted(label_condition(name)) for name in design.conditions]
    )
    axis.tick_params(axis="x", colors=INK, length=0)
    axis.set_xlim(-0.4, len(design.conditions) - 0.6)
    axis.grid(visible=False, axis="x")
    axis.set_ylabel(y_label)
    rows = [
        (person, name, float(value))
        for person, values in zip(design.participants, design.values, strict=True)
        for name, value in zip(design.conditions, values, strict=True)
    ]
    return finish_chart(figure, mark_title(title, mark), "", HEADER, rows)
