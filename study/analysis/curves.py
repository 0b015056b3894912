"""Discrepancies over the iterations: mean and band over runs, beside reference lines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from study.analysis.drawing import Chart, finish_chart, new_figure, style_of
from study.errors import InvalidValue

Floats = npt.NDArray[np.float64]
POINTS = 48
BAND = (0.1, 0.9)
HEADER = ("measure", "line", "first_iteration", "last_iteration", "runs", "mean", "low", "high")
MEASURES: Mapping[str, str] = MappingProxyType(
    {
        "disable": "proposed on, expert off\n(the paper's count)",
        "enable": "proposed off, expert on\n(the converse count)",
        "off_rate": "the paper's count per\nelement compared",
        "hamming_rate": "elements that differ per\nelement compared",
        "shown_share": "elements proposed on per\nelement compared",
    }
)
LINES: Mapping[str, str] = MappingProxyType(
    {
        "policy": "VARIL: the policy of the iteration",
        "arroch": "ARROCH: all of a robot, no balloon",
        "all_off": "nothing at all",
        "majority": "each element as it mostly was",
        "floor": "best table in hindsight",
    }
)


@dataclass(frozen=True, eq=False)
class Curve:
    """Mean and band over runs, float64[points]; a point stands for a block of iterations."""

    first: npt.NDArray[np.int64]
    last: npt.NDArray[np.int64]
    mean: Floats
    low: Floats
    high: Floats
    runs: int


def average_runs(series: Floats, points: int = POINTS) -> Curve:
    """Average float64[runs, J] over blocks of iterations, then over runs.

    Iterations count from 1. The band holds the middle 80 % of the runs.
    Errors: InvalidValue for an empty table.
    """
    table = np.asarray(series, np.float64)
    if table.ndim != 2 or not table.size:
        raise InvalidValue(f"a curve needs runs and iterations, not a table {table.shape}")
    total = table.shape[1]
    starts = np.arange(0, total, max(1, total // points))
    ends = np.append(starts[1:], total)
    blocks = np.add.reduceat(table, starts, axis=1) / (ends - starts)
    low, high = np.quantile(blocks, BAND, axis=0)
    return Curve(starts + 1, ends, blocks.mean(axis=0), low, high, len(table))


def draw_discrepancies(
    found: Mapping[str, Mapping[str, Floats]], *, title: str, mark: str
) -> Chart:
    """Draw one panel per measure in `MEASURES`; `found[measure][line]` is float64[runs, J]."""
    figure, axes = new_figure(9.0, 5.2, rows=2, columns=3, share=False)
    rows: list[tuple[str | int | float, ...]] = []
    for axis, (measure, label) in zip(axes, MEASURES.items(), strict=False):
        for line in LINES:
            curve = average_runs(found[measure][line])
            _draw_curve(axis, line, curve)
            rows += _curve_rows(measure, line, curve)
        axis.set_ylabel(label, fontsize=8.5)
        axis.set_ylim(bottom=0)
    for axis in axes[2:5]:
        axis.set_xlabel("iteration")
    runs, block = curve.runs, int(curve.last[0])
    _explain(axes[5], axes[0], runs, block)
    return finish_chart(figure, title, mark, HEADER, rows)


def _draw_curve(axis: Axes, line: str, curve: Curve) -> None:
    style = style_of("varil" if line == "policy" else line)
    at = (curve.first + curve.last) / 2
    width = 2.0 if line == "policy" else 1.2
    axis.plot(at, curve.mean, color=style.colour, linestyle=style.dash, linewidth=width,
              label=LINES[line])  # fmt: skip
    if curve.runs > 1:
        axis.fill_between(at, curve.low, curve.high, color=style.colour, alpha=0.14, linewidth=0)


def _curve_rows(measure: str, line: str, curve: Curve) -> list[tuple[str | int | float, ...]]:
    columns = (curve.first, curve.last, curve.mean, curve.low, curve.high)
    return [
        (measure, line, int(first), int(last), curve.runs, *(round(float(v), 6) for v in values))
        for first, last, *values in zip(*columns, strict=True)
    ]


def _explain(empty: Axes, example: Axes, runs: int, block: int) -> None:
    """Put the legend into the panel that holds no measure."""
    empty.set_axis_off()
    handles, labels = example.get_legend_handles_labels()
    over = f"mean of {runs} runs, band: middle 80 %" if runs > 1 else "one run"
    per = f"\neach point: {block} iterations" if block > 1 else ""
    empty.legend(handles, labels, frameon=False, loc="center left", fontsize=8, title=over + per)
