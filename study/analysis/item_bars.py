"""Questionnaire bars: the mean of each item per condition, with marks of significance.

As the paper draws them; the test and correction behind the marks stand in the figure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from study.analysis.cases import label_condition
from study.analysis.descriptives import Summary, summarise
from study.analysis.designs import Design
from study.analysis.drawing import INK, Chart, finish_chart, new_figure, style_of
from study.analysis.wording import mark_title, unformatted

HEADER = ("item", "condition", "n", "mean", "low", "high")
Pair = tuple[str, str]


@dataclass(frozen=True)
class ItemScale:
    """The points of a scale with their labels, empty for open scales; what marks mean."""

    points: tuple[tuple[float, str], ...]
    legend: str


def mark_of(p: float | None) -> str:
    """`**` below 0.01, `*` below 0.05, else nothing."""
    if p is None or p >= 0.05:
        return ""
    return "**" if p < 0.01 else "*"


def draw_items(
    designs: Sequence[Design],
    marks: Mapping[str, Mapping[Pair, str]],
    scale: ItemScale,
    *,
    title: str,
    mark: str,
) -> Chart:
    """Draw items side by side, a bar per condition, whiskers for the interval of the mean.

    `marks` are by item and pair. Each design has at least one participant. Rows: one per item and
    condition; bounds that do not exist equal the mean.
    """
    conditions = designs[0].conditions
    figure, (axis,) = new_figure(max(5.4, 1.8 + 1.0 * len(designs)), 4.3)
    values = [value for value, _ in scale.points]
    base = min(values, default=0.0)
    found = [[summarise(design.column(name)) for name in conditions] for design in designs]
    for place, name in enumerate(conditions):
        _draw_condition(axis, name, place, len(conditions), [row[place] for row in found], base)
    tops = [max(_bounds(one)[1] for one in row) for row in found]
    step = 0.055 * max(max(tops) - base, max(values, default=base) - base, 1e-9)
    highest = max(tops)
    for middle, (design, top) in enumerate(zip(designs, tops, strict=True)):
        own = [(pair, text) for pair, text in marks.get(design.measure, {}).items() if text]
        for level, (pair, text) in enumerate(own):
            ends = [middle + _offset(conditions.index(name), len(conditions)) for name in pair]
            drawn = _draw_bracket(axis, ends, top + (0.6 + 1.25 * level) * step, step, text)
            highest = max(highest, drawn)
    axis.set_ylim(base, max(highest, *tops, *values) + step)
    if scale.points:
        texts = [f"{unformatted(label)}  {value:g}" for value, label in scale.points]
        axis.set_yticks(values, texts)
    axis.set_xticks(range(len(designs)), [unformatted(d.measure) for d in designs])
    axis.tick_params(axis="x", colors=INK, length=0)
    axis.grid(visible=False, axis="x")
    figure.legend(
        *axis.get_legend_handles_labels(), loc="outside lower center", ncols=len(conditions),
        frameon=False, fontsize=8, title=scale.legend, title_fontsize=7,
    )  # fmt: skip
    rows = [
        (design.measure, name, one.n, float(one.mean or 0.0), *_bounds(one))
        for design, row in zip(designs, found, strict=True)
        for name, one in zip(conditions, row, strict=True)
    ]
    return finish_chart(figure, mark_title(title, mark), "", HEADER, rows)


def _offset(place: int, conditions: int) -> float:
    return (place - (conditions - 1) / 2) * _width(conditions)


def _width(conditions: int) -> float:
    return 0.8 / conditions


def _bounds(one: Summary) -> tuple[float, float]:
    mean = float(one.mean or 0.0)
    if one.low is None or one.high is None:
        return mean, mean
    return one.low, one.high


def _draw_condition(
    axis: Axes, name: str, place: int, conditions: int, found: Sequence[Summary], base: float
) -> None:
    style = style_of(name, place)
    at = [middle + _offset(place, conditions) for middle in range(len(found))]
    means = [float(one.mean or 0.0) for one in found]
    reach = [
        [mean - _bounds(one)[0] for mean, one in zip(means, found, strict=True)],
        [_bounds(one)[1] - mean for mean, one in zip(means, found, strict=True)],
    ]
    axis.bar(
        at, [mean - base for mean in means], bottom=base, width=0.94 * _width(conditions),
        facecolor=_tint(style.colour), edgecolor=style.colour, hatch=style.hatch, linewidth=0.8,
        label=unformatted(label_condition(name)),
    )  # fmt: skip
    axis.errorbar(at, means, yerr=reach, fmt="none", color=INK, capsize=2.5, linewidth=1.0)


def _tint(colour: str) -> tuple[float, float, float]:
    """The colour half way to white; opaque, so that hatching in the colour itself shows."""
    red, green, blue = to_rgb(colour)
    return (0.5 + red / 2, 0.5 + green / 2, 0.5 + blue / 2)


def _draw_bracket(axis: Axes, ends: list[float], height: float, step: float, text: str) -> float:
    """Draw a bracket with its mark; returns the height up to which it reaches."""
    foot = height - 0.3 * step
    axis.plot(
        [ends[0], ends[0], ends[1], ends[1]], [foot, height, height, foot],
        color=INK, linewidth=0.9,
    )  # fmt: skip
    middle = (ends[0] + ends[1]) / 2
    axis.text(middle, height - 0.15 * step, text, ha="center", va="bottom", fontsize=9)
    return height + step
