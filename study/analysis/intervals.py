"""Intervals by seeded bootstrap: percentile intervals of a mean and of a mean paired difference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from study.errors import InvalidValue

Floats = npt.NDArray[np.float64]
DRAWS = 4000
LEVEL = 0.95


@dataclass(frozen=True)
class Interval:
    """A mean of n values with the bounds of its interval; with n = 1 both bounds are the mean."""

    mean: float
    low: float
    high: float
    n: int

    @property
    def excludes_zero(self) -> bool:
        """Whether the whole interval lies on one side of 0."""
        return self.low > 0 or self.high < 0


def bootstrap_mean(
    values: Sequence[float] | Floats, seed: int, *, draws: int = DRAWS, level: float = LEVEL
) -> Interval:
    """Interval of the mean from `draws` resamples. Errors: InvalidValue without finite values."""
    sample = np.asarray(values, np.float64)
    if sample.ndim != 1 or not len(sample) or not np.isfinite(sample).all():
        raise InvalidValue(
            "an interval needs at least one value, all of them finite",
            next_step="Leave out rows without a value.",
        )
    generator = np.random.default_rng(seed)
    means = np.empty(draws)
    block = max(1, 2_000_000 // len(sample))  # resamples at a time: memory stays below 32 MB
    for start in range(0, draws, block):
        count = min(block, draws - start)
        means[start : start + count] = sample[
            generator.integers(0, len(sample), (count, len(sample)))
        ].mean(axis=1)
    return _between(float(sample.mean()), means, level, len(sample))


def bootstrap_paired(
    ours: Sequence[float] | Floats,
    theirs: Sequence[float] | Floats,
    seed: int,
    *,
    draws: int = DRAWS,
    level: float = LEVEL,
) -> Interval:
    """Interval of the mean of ours - theirs; entry n of both belongs together."""
    if len(ours) != len(theirs):
        raise InvalidValue(f"pairs need two columns of one length, not {len(ours)}, {len(theirs)}")
    differences = np.asarray(ours, np.float64) - np.asarray(theirs, np.float64)
    return bootstrap_mean(differences, seed, draws=draws, level=level)


def bootstrap_crossed(
    values: Floats, seed: int, *, draws: int = DRAWS, level: float = LEVEL
) -> Interval:
    """Interval of the mean of values float64[runs, trials] whose rows and columns are both drawn.

    Each resample draws runs and, apart from that, trials, so that what a run's trials have in
    common and what a trial has in common over runs both widen the interval. `n` counts trials.
    """
    table = np.asarray(values, np.float64)
    if table.ndim != 2 or not table.size or not np.isfinite(table).all():
        raise InvalidValue("a crossed interval needs a full table of finite values")
    runs, trials = table.shape
    generator = np.random.default_rng(seed)
    picks, weights = _shares(generator, runs, draws), _shares(generator, trials, draws)
    means = np.einsum("dt,dt->d", picks @ table, weights)
    return _between(float(table.mean()), means, level, trials)


def bootstrap_difference(
    ours: Floats,
    theirs: Floats,
    seed: int,
    *,
    shared_runs: bool = False,
    draws: int = DRAWS,
    level: float = LEVEL,
) -> Interval:
    """Interval of mean(ours) - mean(theirs), float64[runs, trials] each, trial by trial.

    Trials are drawn once for both. Runs are drawn for each on its own, or once for both where
    run n of one belongs to run n of the other (`shared_runs`). `n` counts trials.
    """
    mine, other = np.asarray(ours, np.float64), np.asarray(theirs, np.float64)
    if mine.ndim != 2 or other.ndim != 2 or mine.shape[1] != other.shape[1]:
        raise InvalidValue(f"tables {mine.shape} and {other.shape} do not hold the same trials")
    if shared_runs:
        return bootstrap_crossed(mine - other, seed, draws=draws, level=level)
    generator = np.random.default_rng(seed)
    picks = _shares(generator, len(mine), draws)
    others = _shares(generator, len(other), draws)
    weights = _shares(generator, mine.shape[1], draws)
    differences = picks @ mine - others @ other
    means = np.einsum("dt,dt->d", differences, weights)
    return _between(float(mine.mean() - other.mean()), means, level, mine.shape[1])


def _shares(generator: np.random.Generator, count: int, draws: int) -> Floats:
    """How often each of `count` is drawn, as shares: float64[draws, count]."""
    return generator.multinomial(count, np.full(count, 1 / count), draws) / count


def _between(mean: float, means: Floats, level: float, n: int) -> Interval:
    low, high = np.quantile(means, [(1 - level) / 2, (1 + level) / 2])
    return Interval(mean, min(float(low), mean), max(float(high), mean), n)
