"""Intervals one below the other around a line of no difference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from study.analysis.drawing import INK, Chart, finish_chart, new_figure, style_of
from study.analysis.intervals import Interval
from study.errors import InvalidValue

HEADER = ("label", "series", "n", "mean", "low", "high")
_MARKERS = "osD^vP"


@dataclass(frozen=True)
class Entry:
    """One interval: entries with one label share a line, each series has its own marker."""

    label: str
    series: str
    interval: Interval


def draw_forest(
    entries: Sequence[Entry], *, title: str, x_label: str, mark: str, base: float | None = None
) -> Chart:
    """Draw entries from top to bottom; `base`: a dotted line, as for the unchanged case.

    Errors: InvalidValue without entries.
    """
    if not entries:
        raise InvalidValue("there is no interval to draw")
    labels = list(dict.fromkeys(entry.label for entry in entries))
    series = list(dict.fromkeys(entry.series for entry in entries))
    figure, (axis,) = new_figure(7.2, 1.1 + 0.30 * len(labels) * max(1.0, 0.55 * len(series)))
    axis.axvline(0.0, color=INK, linewidth=1.0)
    if base is not None:
        axis.axvline(base, color=INK, linewidth=0.8, linestyle=":")
    for place, name in enumerate(series):
        mine = [entry for entry in entries if entry.series == name]
        shift = (place - (len(series) - 1) / 2) * 0.6 / max(1, len(series))
        heights = [labels.index(entry.label) + shift for entry in mine]
        means = [entry.interval.mean for entry in mine]
        below = [entry.interval.mean - entry.interval.low for entry in mine]
        above = [entry.interval.high - entry.interval.mean for entry in mine]
        axis.errorbar(
            means, heights, xerr=(below, above), fmt=_MARKERS[place % len(_MARKERS)],
            color=style_of(name, place).colour, markersize=4.5, elinewidth=1.3, capsize=2.5,
            label=name,
        )  # fmt: skip
    axis.set_yticks(range(len(labels)), labels)
    axis.set_ylim(len(labels) - 0.4, -0.6)
    axis.grid(visible=False, axis="y")
    axis.set_xlabel(x_label)
    if len(series) > 1:
        figure.legend(frameon=False, loc="outside lower center", ncols=len(series), fontsize=8)
    rows = [
        (entry.label, entry.series, entry.interval.n, *_bounds(entry.interval)) for entry in entries
    ]
    return finish_chart(figure, title, mark, HEADER, rows)


def _bounds(interval: Interval) -> tuple[float, float, float]:
    return round(interval.mean, 6), round(interval.low, 6), round(interval.high, 6)
