"""`varil learn`: PolicyUp with simulated people; dataset, every policy version, discrepancies.

All that it writes is simulated: no row here speaks about people.
"""

from __future__ import annotations

import csv
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from server.desks.learned_policies import describe_version
from server.headless.trials import choose_scale
from server.kernel_cache import open_kernel_cache
from study.learning.classifiers import choose_classifier
from study.learning.curve import RATES
from study.learning.dataset import Dataset
from study.learning.dataset_rows import DATASET_FIELDS, dataset_row
from study.learning.discrepancies import REFERENCES, Discrepancies, measure
from study.learning.policy import Policy, initial_policy
from study.learning.policy_up import PolicyUp, Version
from study.learning.settings import PAIRS_PER_ITERATION, LearningSettings
from study.people.habits import Habits
from study.people.learning_run import check_people, run_learning
from study.people.parameters import parameter_version
from study.warehouse.halls import HallSpec
from study.warehouse.layout import build_layout

FIRST = slice(0, 5)
LAST = slice(-40, None)
LINE_EVERY_S = 5.0
COUNTS = ("compared", "disable", "enable", "shown")


@dataclass(frozen=True)
class LearningOptions:
    """What `varil learn` was asked for. hall: another one than the preset of the scale's name."""

    out: Path
    settings: LearningSettings = field(default_factory=LearningSettings)
    scale: str = "study"
    hall: HallSpec | None = None
    habits: Habits = field(default_factory=Habits)
    expert: str = "person"
    worker: str = "believer"
    quiet: bool = False


def learn(options: LearningOptions) -> dict[str, Any]:
    """Run PolicyUp, write its files into the folder, return the summary.

    Files: dataset.csv, discrepancies.csv, policies/000.json to policies/<iterations>.json. Those
    of an earlier run in the same folder are replaced, none of them stays. Errors: InvalidValue for
    an unknown scale, worker, expert or classifier; OSError for an unusable folder, before the run.
    """
    spec = options.hall or choose_scale(options.scale)
    check_people(options.worker, options.expert)
    choose_classifier(options.settings.classifier)
    folder = options.out / "policies"
    folder.mkdir(parents=True, exist_ok=True)
    started_s = time.perf_counter()
    console = Console(stderr=True, quiet=options.quiet)
    console.print("Preparing the compiled world (up to a minute the first time) ...")
    open_kernel_cache()
    with _Watch(options, console) as watch:
        up = run_learning(
            options.settings,
            build_layout(spec),
            options.worker,
            options.expert,
            watch.tell,
            options.habits,
        )
    found = measure(up.dataset, options.settings.iterations)
    for former in folder.glob("*.json"):
        if former.stem.isdigit():
            former.unlink()
    for version in up.versions:
        policy = describe_policy(version, options, found["policy"])
        (folder / f"{version.iterations:03}.json").write_text(policy.to_json(), encoding="utf-8")
    write_dataset(options.out / "dataset.csv", up.dataset, options.settings)
    write_discrepancies(options.out / "discrepancies.csv", found)
    return _summarize(up, options, found, policy.sha256, time.perf_counter() - started_s)


def describe_policy(version: Version, options: LearningOptions, own: Discrepancies) -> Policy:
    """Return a version as a policy with its origin; the initial one was taught by nobody."""
    if version.iterations == 0:
        return initial_policy(options.settings.thresholds)
    people: dict[str, Any] = {
        "scale": options.scale,
        "expert": options.expert,
        "worker": options.worker,
        "people_version": parameter_version(),
        "habits": options.habits.to_json(),
    }
    if options.hall is not None:
        people["hall"] = options.hall.to_json()
    prefix = f"{options.expert}-{options.settings.seed}"
    return describe_version(version, options.settings, own, "simulated", prefix, people)


def write_dataset(path: Path, dataset: Dataset, settings: LearningSettings) -> None:
    """Write a row per pair."""
    rows = (dataset_row(pair, settings, "simulated") for pair in dataset)
    _write_table(path, DATASET_FIELDS, rows)


def write_discrepancies(path: Path, found: Mapping[str, Discrepancies]) -> None:
    """Write a row per iteration and line: the policy's own and each reference."""
    rows = (
        (
            iteration,
            line,
            *(int(getattr(found[line], name)[iteration]) for name in COUNTS),
            *(
                round(getattr(found[line], name)(slice(iteration, iteration + 1)), 6)
                for name in RATES
            ),
            "simulated",
        )
        for line in ("policy", *REFERENCES)
        for iteration in range(len(found[line].compared))
    )
    _write_table(path, ("iteration", "line", *COUNTS, *RATES, "origin"), rows)


def _write_table(path: Path, header: Iterable[str], rows: Iterable[tuple[Any, ...]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)


def _summarize(
    up: PolicyUp,
    options: LearningOptions,
    found: Mapping[str, Discrepancies],
    policy_sha256: str,
    wall_s: float,
) -> dict[str, Any]:
    """Return the figures of a run, with the keys that `--json` promises."""
    own, arroch = found["policy"], found["arroch"]
    return {
        "iterations": up.j,
        "pairs": up.units,
        "expert": options.expert,
        "off_rate_first5": round(own.off_rate(FIRST), 6),
        "off_rate_last40": round(own.off_rate(LAST), 6),
        "hamming_first5": round(own.hamming_rate(FIRST), 6),
        "hamming_last40": round(own.hamming_rate(LAST), 6),
        "arroch_off_rate_last40": round(arroch.off_rate(LAST), 6),
        "arroch_hamming_last40": round(arroch.hamming_rate(LAST), 6),
        "shown_share_last40": round(own.shown_share(LAST), 6),
        "policy_sha256": policy_sha256,
        "wall_s": round(wall_s, 3),
    }


class _Watch:
    """A bar on a terminal, else a line now and then."""

    def __init__(self, options: LearningOptions, console: Console) -> None:
        self._total = options.settings.iterations
        self._console = console
        columns = (TextColumn("iterations"), BarColumn(), MofNCompleteColumn())
        self._progress = Progress(
            *columns, TimeRemainingColumn(), console=console, disable=not console.is_terminal
        )
        self._bar = self._progress.add_task("", total=self._total)
        self._told_s = time.perf_counter()

    def __enter__(self) -> _Watch:
        self._progress.start()
        return self

    def __exit__(self, *trouble: object) -> None:
        self._progress.stop()

    def tell(self, up: PolicyUp) -> None:
        """Show how far the run is."""
        self._progress.update(self._bar, completed=up.j)
        now_s = time.perf_counter()
        if not self._console.is_terminal and now_s - self._told_s >= LINE_EVERY_S:
            self._told_s = now_s
            self._console.print(
                f"{up.j} of {self._total} iterations, {up.j * PAIRS_PER_ITERATION} pairs"
            )
