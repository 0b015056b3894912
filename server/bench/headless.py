"""`varil bench headless`: steps a second on one core, and how long the paper's table takes.

Steps are 30 Hz steps of the world at `study` scale. The first part runs batches of trials in this
process, one after the other in turns: the worker `believer` with a learned policy, which is what a
study of policies needs, and the worker `cyclic`, who looks at nothing. The second part runs 6
policies with 250 trials each over worker processes.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from statistics import median
from typing import Any

from server.bench.machine import describe_machine
from server.evaluation.groups import POINTS
from server.headless.backends import Backend
from server.headless.trials import BatchWork
from server.kernel_cache import open_kernel_cache
from study.headless import simulate_many
from study.learning.policy import Policy
from study.learning.policy_up import Version
from study.learning.settings import LearningSettings
from study.people.habits import Habits
from study.people.learning_run import run_learning
from study.warehouse.layout import PRESETS, build_layout

LIBRARIES = ("joblib", "numba", "numpy")
GOAL_STEPS_PER_S = 200_000
GOAL_TABLE_S = 60.0
BATCH = 25
FIRST_SEED = 5000


def measure_headless(
    repeats: int = 5, trials: int = 20, table_trials: int = 250, workers: int | None = None
) -> dict[str, Any]:
    """Steps per second of processor time, and the wall time of the table of 6 policies."""
    open_kernel_cache()
    policies = learn_policies()
    processes = workers or os.cpu_count() or 1
    report: dict[str, Any] = {
        "benchmark": "headless",
        "scale": "study",
        "steps": measure_steps(policies[-1], repeats, trials),
    }
    if table_trials:
        walls = [time_table(policies, table_trials, processes) for _ in range(repeats)]
        report["table"] = {
            "policies": len(policies),
            "trials": table_trials * len(policies),
            "workers": processes,
            "wall_s_median": median(walls),
            "wall_s_all": walls,
            "goal_s": GOAL_TABLE_S,
        }
    return report | describe_machine(LIBRARIES)


def measure_steps(policy: Policy, repeats: int, trials: int) -> dict[str, Any]:
    """Steps per second of processor time, batches of both workers in turns on other seeds."""
    layout = build_layout(PRESETS["study"])
    kinds = {
        "believer_with_policy": ("believer", "varil", policy),
        "cyclic": ("cyclic", "none", None),
    }
    found: dict[str, list[int]] = {name: [] for name in kinds}
    for repeat in range(repeats + 1):
        first = FIRST_SEED + repeat * trials
        for name, (worker, condition, shown) in kinds.items():
            started_s = time.process_time()
            seeds = range(first, first + (trials if repeat else 1))
            done = list(simulate_many(layout, seeds, worker, condition, shown))
            taken_s = time.process_time() - started_s
            if repeat:  # the first round only loads compiled code
                found[name].append(round(sum(each.measures.ticks for each in done) / taken_s))
    medians = {name: median(values) for name, values in found.items()}
    ratio = medians["believer_with_policy"] / medians["cyclic"]
    return {
        "trials_each": trials,
        "per_s_per_core_median": medians,
        "per_s_per_core_all": found,
        "believer_over_cyclic": round(ratio, 3),
        "goal_per_s_per_core": GOAL_STEPS_PER_S,
    }


def time_table(policies: Sequence[Policy], trials: int, processes: int) -> float:
    """Wall seconds of all trials of all policies over fresh or warm worker processes."""
    started_s = time.perf_counter()
    pieces = list(_pieces(policies, trials))
    finished = sum(len(batch.trials) for batch in Backend(processes=processes).run(_run, pieces))
    if finished != trials * len(policies):
        raise RuntimeError(f"{finished} of {trials * len(policies)} trials came back")
    return round(time.perf_counter() - started_s, 3)


def learn_policies() -> list[Policy]:
    """P1 to P6 of one learning run with the table expert."""
    settings = LearningSettings(seed=1)
    up = run_learning(settings, build_layout(PRESETS["study"]), "believer", "table")
    return [_as_policy(up.versions[point], settings) for point in POINTS]


def _pieces(policies: Sequence[Policy], trials: int) -> Iterator[tuple[Policy, list[int]]]:
    for first in range(0, trials, BATCH):
        for policy in policies:
            yield policy, [FIRST_SEED + n for n in range(first, min(first + BATCH, trials))]


def _run(piece: tuple[Policy, list[int]]) -> Any:
    policy, seeds = piece
    return BatchWork(PRESETS["study"], "believer", "varil", policy, Habits())(seeds)


def _as_policy(version: Version, settings: LearningSettings) -> Policy:
    return Policy(
        name=f"bench-{version.iterations:03}",
        origin="simulated",
        thresholds=settings.thresholds,
        robot_table=version.tables[0],
        station_table=version.tables[1],
    )
