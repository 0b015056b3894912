"""Histograms with Gaussian curves, as the paper draws waiting times: one curve per group.

Up to three groups share one pair of axes, as in the paper; more get a panel each on one x axis,
since six curves in one place cannot be told apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from study.analysis.drawing import INK, Chart, Style, finish_chart, new_figure, style_of
from study.errors import InvalidValue

Floats = npt.NDArray[np.float64]
TOGETHER = 3
HEADER = ("group", "n", "mean", "sd", "bin_low", "bin_high", "count", "gauss_count")
_NICE = (1.0, 2.0, 2.5, 5.0, 10.0)


def draw_histogram(
    groups: Mapping[str, Sequence[float] | Floats],
    *,
    title: str,
    x_label: str,
    y_label: str,
    mark: str,
    labels: Mapping[str, str] | None = None,
) -> Chart:
    """Draw each group's histogram and the Gaussian of its mean and standard deviation.

    The y axis counts; where groups differ in size it shows their shares, in per cent.
    Rows: one per group and bin; `gauss_count` is the curve at the bin's middle, in counts; a group
    of one value or without spread has no curve (sd 0, gauss_count 0).
    Errors: InvalidValue without groups, or naming a group without finite values.
    """
    samples = {name: _check(name, values) for name, values in groups.items()}
    if not samples:
        raise InvalidValue("there is no group to draw a histogram of")
    edges = choose_bins(list(samples.values()))
    uneven = len({len(sample) for sample in samples.values()}) > 1
    shared = len(samples) <= TOGETHER
    panels = 1 if shared else len(samples)
    figure, axes = new_figure(6.8, 4.0 if shared else 0.7 + 1.05 * panels, rows=panels)
    rows: list[tuple[str | int | float, ...]] = []
    for place, (name, sample) in enumerate(samples.items()):
        axis = axes[0] if shared else axes[place]
        label = (labels or {}).get(name, name)
        unit = 100.0 / len(sample) if uneven else 1.0
        _draw_group(axis, sample, edges, unit, style_of(name, place), label)
        rows += _group_rows(name, sample, edges)
    first = float(next(iter(samples.values())).mean())
    top = max(axis.get_ylim()[1] for axis in axes)
    for axis in axes:
        if not shared:
            axis.axvline(first, color=INK, linewidth=0.8, linestyle=":")
        axis.legend(frameon=False, loc="upper right", fontsize=8)
        axis.set_ylim(0, top)
    axes[-1].set_xlabel(x_label if shared else f"{x_label}; dotted: mean of the first group")
    figure.supylabel(f"share of {y_label} (%)" if uneven else y_label, fontsize=9, color=INK)
    return finish_chart(figure, title, mark, HEADER, rows)


def choose_bins(samples: Sequence[Floats]) -> Floats:
    """Edges common to all samples, of a round width by Freedman and Diaconis over the pool."""
    pool = np.concatenate([np.asarray(sample, np.float64) for sample in samples])
    low, high = float(pool.min()), float(pool.max())
    if high <= low:
        return np.array([low - 0.5, low + 0.5])
    spread = float(np.subtract(*np.quantile(pool, [0.75, 0.25])))
    smallest = min(len(sample) for sample in samples)
    wide = 2 * spread / smallest ** (1 / 3) if spread > 0 else (high - low) / 8
    width = round_nicely(max(wide, (high - low) / 60))
    first = np.floor(low / width)
    count = int(np.floor(high / width) - first) + 1
    return np.asarray((first + np.arange(count + 1)) * width, np.float64)


def round_nicely(value: float) -> float:
    """The nearest of 1, 2, 2.5 and 5 times a power of ten, by ratio; the value is above 0."""
    power = float(10.0 ** np.floor(np.log10(value)))
    return power * min(_NICE, key=lambda nice: abs(float(np.log(nice * power / value))))


def gauss_counts(sample: Floats, at: Floats, width: float) -> Floats:
    """The Gaussian of the sample's mean and standard deviation in counts per bin of a width."""
    sd = float(sample.std(ddof=1)) if len(sample) > 1 else 0.0
    if sd == 0.0:
        return np.zeros_like(at)
    z = (at - sample.mean()) / sd
    curve = np.exp(-0.5 * z * z) / (sd * np.sqrt(2 * np.pi))
    return np.asarray(curve * len(sample) * width, np.float64)


def _check(name: str, values: Sequence[float] | Floats) -> Floats:
    sample = np.asarray(values, np.float64)
    if sample.ndim != 1 or not len(sample) or not np.isfinite(sample).all():
        raise InvalidValue(
            f"the group “{name[:40]}” has no values or some that are not finite",
            next_step="Leave the group out, or its rows without a value.",
        )
    return sample


def _draw_group(
    axis: Axes, sample: Floats, edges: Floats, unit: float, style: Style, label: str
) -> None:
    counts = np.histogram(sample, edges)[0] * unit
    axis.stairs(
        counts, edges, fill=True, facecolor=(style.colour, 0.22), edgecolor=(style.colour, 0.75),
        linewidth=0.8,
    )  # fmt: skip
    text = f"{label} (n = {len(sample)}, mean {sample.mean():.0f})"
    at = np.linspace(edges[0], edges[-1], 241)
    curve = gauss_counts(sample, at, float(edges[1] - edges[0])) * unit
    axis.plot(at, curve, color=style.colour, linestyle=style.dash, linewidth=1.8, label=text)


def _group_rows(name: str, sample: Floats, edges: Floats) -> list[tuple[str | int | float, ...]]:
    counts, _ = np.histogram(sample, edges)
    middle = (edges[:-1] + edges[1:]) / 2
    curve = gauss_counts(sample, middle, float(edges[1] - edges[0]))
    sd = float(sample.std(ddof=1)) if len(sample) > 1 else 0.0
    what = (name, len(sample), round(float(sample.mean()), 6), round(sd, 6))
    return [
        (*what, float(low), float(high), int(count), round(float(height), 6))
        for low, high, count, height in zip(edges[:-1], edges[1:], counts, curve, strict=True)
    ]
