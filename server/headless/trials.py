"""`varil simulate`: many headless trials over all cores, two tables and a summary.

The `believer` acts on what the condition displays. The other workers know the world itself and
look at no display: for them the condition is checked and written into the rows, no more.
"""

from __future__ import annotations

import csv
import hashlib
import json
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from server.headless.backends import Backend, NoCluster
from server.kernel_cache import kernel_digest, open_kernel_cache
from server.policy_files import read_policy_file, shipped_policy
from study.ar.conditions import build_condition
from study.ar.thresholds import Thresholds
from study.errors import InvalidValue
from study.headless import HeadlessTrial, check_worker, simulate_many, simulate_trial
from study.learning.policy import Policy
from study.people.habits import Habits
from study.people.parameters import parameter_version
from study.records.tables import ROBOTS, TRIALS
from study.warehouse.layout import PRESETS, HallSpec, build_layout

STUDY_ID = "simulate"
POLICY_FILE = "policy.json"
LARGEST_BATCH = 25
LINE_EVERY_S = 5.0


@dataclass(frozen=True)
class SimulationOptions:
    """What `varil simulate` was asked for. Trial n runs with seed `seed` + n.

    policy: a file or a policy itself, for the condition `varil`; None = the shipped one.
    hall: another hall than the preset of the scale's name.
    """

    out: Path
    condition: str = "none"
    policy: Path | Policy | None = None
    scale: str = "study"
    hall: HallSpec | None = None
    habits: Habits = field(default_factory=Habits)
    worker: str = "cyclic"
    trials: int = 10
    seed: int = 0
    backend: Backend = field(default_factory=Backend)
    quiet: bool = False


def run_simulation(options: SimulationOptions) -> dict[str, Any]:
    """Run the trials, write their files into the folder, return the summary.

    Files: trials.csv, robots.csv and, for the condition `varil`, the policy as policy.json.
    Errors: StudyError subclasses for an unknown condition, scale or worker or a bad policy file.
    """
    spec = options.hall or choose_scale(options.scale)
    check_worker(options.worker)
    policy = _choose_policy(options)
    build_condition(options.condition, policy)
    options.out.mkdir(parents=True, exist_ok=True)
    console = Console(stderr=True, quiet=options.quiet)
    console.print("Preparing the compiled world (up to a minute the first time) ...")
    open_kernel_cache()
    simulate_trial(build_layout(PRESETS["practice"]), 0, options.worker)
    started_s = time.perf_counter()
    work = BatchWork(spec, options.worker, options.condition, policy, options.habits)
    batches = list(_watch(options, work, console))
    wall_s = time.perf_counter() - started_s
    finished = sorted((t for batch in batches for t in batch.trials), key=lambda t: t.seed)
    write_tables(options, spec, policy.sha256 if policy else "", finished)
    if policy is not None:
        (options.out / POLICY_FILE).write_text(policy.to_json(), encoding="utf-8")
    cpu_s = sum(batch.cpu_s for batch in batches)
    return summarize(finished, options.seed, wall_s, cpu_s)


@dataclass(frozen=True)
class Batch:
    """Trials that one process ran one after the other, and the processor time they took."""

    trials: list[HeadlessTrial]
    cpu_s: float
    kernels: str


def choose_scale(name: str) -> HallSpec:
    """Return the preset of this name. Errors: InvalidValue naming those that exist."""
    if name not in PRESETS:
        raise InvalidValue(
            f"there is no scale “{name[:40]}”", next_step=f"Use one of: {', '.join(PRESETS)}."
        )
    return PRESETS[name]


def _choose_policy(options: SimulationOptions) -> Policy | None:
    """The policy that decides in the condition `varil`; other conditions follow none."""
    if options.condition != "varil":
        return None
    if isinstance(options.policy, Path):
        policy = read_policy_file(options.policy)
        policy.require_thresholds(Thresholds())
        return policy
    return options.policy or shipped_policy()


def summarize(
    finished: list[HeadlessTrial], seed: int, wall_s: float, cpu_s: float
) -> dict[str, Any]:
    """Return the figures of a run, with the keys that `--json` promises."""
    measures = [trial.measures for trial in finished]
    steps = sum(m.ticks for m in measures)
    return {
        "trials": len(finished),
        "completed": sum(m.status == "completed" for m in measures),
        "timed_out": sum(m.status == "timed_out" for m in measures),
        "overlaps": sum(m.overlaps for m in measures),
        "longest_stall_s": max(m.longest_stall_s for m in measures),
        "steps": steps,
        "steps_per_s_per_core": round(steps / cpu_s) if cpu_s > 0 else 0,
        "wall_s": round(wall_s, 3),
        "sum_wait_s_mean": round(sum(m.sum_wait_s for m in measures) / len(measures), 3),
        "seed": seed,
    }


@dataclass(frozen=True)
class BatchWork:
    """What every batch of a run has in common; called with the seeds of one batch."""

    spec: HallSpec
    worker: str
    condition: str
    policy: Policy | None
    habits: Habits

    def __call__(self, seeds: list[int]) -> Batch:
        """Run trials in a worker process; the code that the parent compiled is only loaded."""
        open_kernel_cache()
        layout = build_layout(self.spec)
        simulate_trial(build_layout(PRESETS["practice"]), 0, self.worker)
        started_s = time.process_time()
        what = (self.worker, self.condition, self.policy, self.habits)
        trials = list(simulate_many(layout, seeds, *what))
        return Batch(trials, time.process_time() - started_s, kernel_digest())


def _results(options: SimulationOptions, work: BatchWork) -> Iterator[Batch]:
    seeds = [options.seed + n for n in range(options.trials)]
    processes = min(options.backend.processes, options.trials)
    size = max(1, min(LARGEST_BATCH, -(-options.trials // (4 * processes))))
    batches = [seeds[n : n + size] for n in range(0, len(seeds), size)]
    for batch in options.backend.run(work, batches):
        if batch.kernels != kernel_digest():
            raise NoCluster(
                "a worker of the cluster runs another version of this program, so its trials "
                "would not be the same",
                next_step="Install the same version, with the same libraries, on every worker.",
            )
        yield batch


def _watch(options: SimulationOptions, work: BatchWork, console: Console) -> Iterator[Batch]:
    """Yield the finished trials; show a bar on a terminal, else a line now and then."""
    if console.is_terminal:
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
        with Progress(*columns, TimeRemainingColumn(), console=console) as progress:
            bar = progress.add_task(f"{options.scale}, {options.worker}", total=options.trials)
            for batch in _results(options, work):
                progress.advance(bar, len(batch.trials))
                yield batch
        return
    done = 0
    told_s = time.perf_counter()
    for batch in _results(options, work):
        done += len(batch.trials)
        if done == options.trials or time.perf_counter() - told_s >= LINE_EVERY_S:
            told_s = time.perf_counter()
            console.print(f"{done} of {options.trials} trials")
        yield batch


def hash_config(spec: HallSpec, habits: Habits) -> str:
    """SHA-256 over the hall and what is set about the simulated people."""
    config = {"hall": spec.to_json(), "habits": habits.to_json(), "people": parameter_version()}
    text = json.dumps(config, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def write_tables(
    options: SimulationOptions,
    spec: HallSpec,
    policy_sha256: str,
    finished: list[HeadlessTrial],
    *,
    with_robots: bool = True,
) -> None:
    """Write one row per trial and one per robot, with the columns that an export has."""
    origin = {
        "study_id": STUDY_ID,
        "config_hash": hash_config(spec, options.habits),
        "mode": "bot",
        "is_bot": "true",
        "participant_code": options.worker,
        "position": 1,
        "condition": options.condition,
        "scale": options.scale,
        "policy_sha256": policy_sha256,
    }
    trials: list[dict[str, Any]] = []
    robots: list[dict[str, Any]] = []
    for trial in finished:
        trial_id = f"{options.scale}-{options.worker}-{trial.seed}"
        row = origin | {"trial_id": trial_id, "seed": trial.seed}
        trials.append(row | vars(trial.measures))
        robots.extend(row | vars(robot) for robot in trial.measures.robots)
    tables = ((TRIALS, trials), (ROBOTS, robots)) if with_robots else ((TRIALS, trials),)
    for table, rows in tables:
        with (options.out / table.file).open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, table.header, extrasaction="ignore")
            writer.writeheader()
            writer.writerows(rows)
