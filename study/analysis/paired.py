"""Paired differences on common seeds: the same trials under two displays, run by run.

A group holds one value per run and seed. A static display has one run; a learned policy has one
for each learning run that made it. Only seeds that all runs of both groups have are compared.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from study.analysis.intervals import Floats, Interval, bootstrap_crossed, bootstrap_difference
from study.errors import InvalidValue

Runs = Mapping[str, Mapping[int, float]]
"""Values by run and seed. Runs of two groups with one name are the same learning run."""


@dataclass(frozen=True)
class Group:
    """A display, control or policy and what its trials measured."""

    name: str
    runs: Runs

    def __post_init__(self) -> None:
        if not self.runs or not all(self.runs.values()):
            raise InvalidValue(f"the group “{self.name[:60]}” holds a run without trials")

    @property
    def seeds(self) -> frozenset[int]:
        """Seeds that every run has."""
        first, *others = (frozenset(run) for run in self.runs.values())
        return first.intersection(*others)

    @property
    def values(self) -> Floats:
        """All values, run by run, seed by seed."""
        return np.array([run[seed] for run in self.runs.values() for seed in sorted(run)])

    def table(self, seeds: list[int]) -> Floats:
        """float64[runs, seeds], runs in order of their names."""
        return np.array([[self.runs[name][seed] for seed in seeds] for name in sorted(self.runs)])


@dataclass(frozen=True)
class Difference:
    """Ours minus theirs over common seeds.

    `shorter`: share of pairs in which ours is less, with its interval. `left_out`: seeds that one
    of the two has and the other lacks.
    """

    ours: str
    theirs: str
    seconds: Interval
    shorter: Interval
    their_mean: float
    runs: int
    left_out: int


def compare_groups(ours: Group, theirs: Group, seed: int) -> Difference | None:
    """The difference of two groups' means; None when they have no seed in common."""
    common = sorted(ours.seeds & theirs.seeds)
    if not common:
        return None
    mine, other = ours.table(common), theirs.table(common)
    shared = sorted(ours.runs) == sorted(theirs.runs)
    known = {seed for group in (ours, theirs) for run in group.runs.values() for seed in run}
    less = mine[:, None, :] < (other[:, None, :] if shared else other[None, :, :])
    return Difference(
        ours=ours.name,
        theirs=theirs.name,
        seconds=bootstrap_difference(mine, other, seed, shared_runs=shared),
        shorter=bootstrap_crossed(less.mean(axis=1), seed),
        their_mean=float(other.mean()),
        runs=max(len(mine), len(other)),
        left_out=len(known) - len(common),
    )


def mean_of(group: Group, seed: int) -> Interval:
    """The mean over runs and the seeds that all of them have.

    Errors: InvalidValue for runs without a common seed.
    """
    if not group.seeds:
        raise InvalidValue(
            f"the runs of “{group.name[:60]}” have no seed in common",
            next_step="Run every policy on the same seeds.",
        )
    return bootstrap_crossed(group.table(sorted(group.seeds)), seed)
