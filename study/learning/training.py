"""Training as an order that can be filled anywhere: counts in, tables out, nothing else needed.

Kept free of the world, so that a process that only trains loads no compiler.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from study.learning.classifiers import Cases, choose_classifier
from study.learning.domains import DOMAINS

Tables = tuple[tuple[int, ...], tuple[int, ...]]
Counts = tuple[npt.NDArray[np.int64], ...]


@dataclass(frozen=True, eq=False)
class TrainingOrder:
    """D at the moment an iteration closed. `iteration`: how many are closed with it.

    counts: per domain int64[states, actions]. latest: the tables in force, kept by a kind of agent
    without any pair. data_sha256: hash over all pairs.
    """

    iteration: int
    counts: Counts
    latest: Tables
    classifier: str
    data_sha256: str


Trainer = Callable[[TrainingOrder], Tables]


def initial_tables() -> Tables:
    """Everything on [paper, Algorithm 1, line 1]."""
    robots, stations = ((domain.actions - 1,) * domain.states for domain in DOMAINS)
    return robots, stations


def train_tables(order: TrainingOrder) -> Tables:
    """Train the next policy on D; a kind of agent without any pair keeps its latest table."""
    learner = choose_classifier(order.classifier)
    robots, stations = (
        tuple(learner.train(domain, Cases.from_counts(counts)).tolist()) if counts.any() else latest
        for domain, counts, latest in zip(DOMAINS, order.counts, order.latest, strict=True)
    )
    return robots, stations
