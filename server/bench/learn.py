"""`varil bench learn`: how long PolicyUp with simulated people takes, and training within it.

A repeat is a whole run of 240 iterations, 6000 pairs, at `study` scale with the worker `believer`.
Training on the different rows, weighted, is measured against training on all rows in turns, within
one run, on the data that the first repeat ended with.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np

from server.bench.machine import describe_machine
from server.kernel_cache import open_kernel_cache
from study.learning.classifiers import Cases, choose_classifier, new_machine
from study.learning.dataset import Dataset
from study.learning.domains import DOMAINS
from study.learning.policy_up import PolicyUp
from study.learning.settings import LearningSettings
from study.people.learning_run import check_people, run_learning
from study.warehouse.layout import PRESETS, Layout, build_layout

LIBRARIES = ("numba", "numpy", "scikit-learn")
GOAL_S = 20.0


def measure_learning(
    repeats: int = 5, expert: str = "person", settings: LearningSettings | None = None
) -> dict[str, Any]:
    """Seconds of whole runs by wall clock and by processor, and the ratio of the two trainings."""
    check_people("believer", expert)
    settings = settings or LearningSettings(seed=1)
    open_kernel_cache()
    layout = build_layout(PRESETS["study"])
    warm = LearningSettings(iterations=1, classifier=settings.classifier)
    run_learning(warm, layout, "believer", expert)
    walls, cpus = [], []
    up, wall_s, cpu_s = _time_run(settings, layout, expert)
    for repeat in range(repeats):
        if repeat:
            _, wall_s, cpu_s = _time_run(settings, layout, expert)
        walls.append(wall_s)
        cpus.append(cpu_s)
    return {
        "benchmark": "learn",
        "scale": "study",
        "expert": expert,
        "worker": "believer",
        "iterations": settings.iterations,
        "pairs": len(up.dataset),
        "trials": up.trial + 1,
        "wall_s_median": median(walls),
        "wall_s_all": walls,
        "cpu_s_median": median(cpus),
        "cpu_s_all": cpus,
        "goal_s": GOAL_S,
        "training": compare_trainings(up.dataset, settings.classifier, repeats),
    } | describe_machine(LIBRARIES)


def compare_trainings(dataset: Dataset, classifier: str, repeats: int) -> dict[str, Any]:
    """Milliseconds to train both kinds of agents, on different rows and on all, in turns."""
    weighted: list[float] = []
    full: list[float] = []
    for _ in range(repeats):
        weighted.append(_time_ms(lambda: _train_weighted(dataset, classifier)))
        full.append(_time_ms(lambda: _train_full(dataset)))
    return {
        "different_rows": sum(int(np.count_nonzero(counts)) for counts in dataset.counts),
        "all_rows": len(dataset),
        "different_ms_median": median(weighted),
        "different_ms_all": weighted,
        "all_ms_median": median(full),
        "all_ms_all": full,
        "ratio": round(median(full) / median(weighted), 1),
    }


def _time_run(
    settings: LearningSettings, layout: Layout, expert: str
) -> tuple[PolicyUp, float, float]:
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    up = run_learning(settings, layout, "believer", expert)
    cpu_s, wall_s = time.process_time() - cpu_s, time.perf_counter() - wall_s
    return up, round(wall_s, 3), round(cpu_s, 3)


def _time_ms(work: Callable[[], None]) -> float:
    started_s = time.perf_counter()
    work()
    return round((time.perf_counter() - started_s) * 1000, 3)


def _train_weighted(dataset: Dataset, classifier: str) -> None:
    learner = choose_classifier(classifier)
    for domain, counts in zip(DOMAINS, dataset.counts, strict=True):
        learner.train(domain, Cases.from_counts(counts))


def _train_full(dataset: Dataset) -> None:
    """The machine over every row, as scikit-learn is used plainly."""
    for domain, counts in zip(DOMAINS, dataset.counts, strict=True):
        cases = Cases.from_counts(counts)
        states = np.repeat(cases.states, cases.counts)
        machine = new_machine()
        machine.fit(domain.features[states], np.repeat(cases.actions, cases.counts))
        machine.predict(domain.features)
