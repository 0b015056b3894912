"""What `make results` runs: every learning run and every set of trials, fixed before the outcome.

docs/results-plan.md says the same in words.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from server.evaluation.groups import POINTS
from study.errors import InvalidValue
from study.learning.controls import CONTROLS
from study.learning.settings import BOX_MODES, LearningSettings
from study.people.habits import VIEWS, WISHES, Habits
from study.people.sensitivity import STRONGEST, WALKING_SPEED, vary
from study.people.worker import BELIEVER, ORACLE
from study.warehouse.halls import PRESETS, HallSpec

BASE = ""
FACTORS: Mapping[str, float] = MappingProxyType({"halved": 0.5, "doubled": 2.0})
DISPLAYS = ("arroch", "crmiar", "none", "full")
WORKERS = (ORACLE, "cyclic")


@dataclass(frozen=True)
class Size:
    """How much is run, and with which seeds: no two sizes share any, so a trial of the machinery
    shows nothing of what will be published.

    first_seed, first_run: seeds of trials and of learning runs are these and on.
    runs, trials: of the main comparison; early_runs: of them, those whose P2 to P5 are run too;
    side_runs, side_trials: of each other expert, classifier or changed parameter.
    """

    first_seed: int
    first_run: int
    scale: str
    iterations: int
    runs: int
    early_runs: int
    trials: int
    side_runs: int
    side_trials: int


SIZES: Mapping[str, Size] = MappingProxyType(
    {
        "full": Size(20_000, 1001, "study", 240, 10, 5, 250, 5, 120),
        "small": Size(90_000, 9001, "study", 240, 2, 2, 12, 2, 6),
        "tiny": Size(80_000, 8001, "practice", 12, 2, 1, 3, 1, 2),
    }
)


@dataclass(frozen=True)
class Way:
    """A way of learning: what differs from the defaults, under a name for tables."""

    name: str
    settings: LearningSettings
    habits: Habits = field(default_factory=Habits)


@dataclass(frozen=True)
class LearnPiece:
    """One learning run; `change`: the name of a changed parameter and how, or `BASE`."""

    way: Way
    change: str
    habits: Habits
    hall: HallSpec
    scale: str
    seed: int

    @property
    def settings(self) -> LearningSettings:
        """The way's settings with this run's seed."""
        return replace(self.way.settings, seed=self.seed)


@dataclass(frozen=True)
class TrialPiece:
    """Trials of one group and run on seeds `first_seed` and on.

    `learned`: the run whose policy after `iteration` iterations decides; else `condition`, which
    may also name a control.
    """

    group: str
    change: str
    condition: str
    worker: str
    habits: Habits
    hall: HallSpec
    scale: str
    first_seed: int
    trials: int
    learned: LearnPiece | None = None
    iteration: int = 0


def choose_size(name: str) -> Size:
    """The size of this name. Errors: InvalidValue naming those that exist."""
    if name not in SIZES:
        raise InvalidValue(
            f"there is no size “{name[:40]}”", next_step=f"Use one of: {', '.join(SIZES)}."
        )
    return SIZES[name]


def points(size: Size) -> tuple[int, ...]:
    """Iterations after which P1 to P6 are taken."""
    return tuple(point * size.iterations // POINTS[-1] for point in POINTS)


def main_ways(size: Size) -> list[Way]:
    """Both box modes with the default expert and classifier."""
    return [
        Way(mode, LearningSettings(iterations=size.iterations, box_mode=mode)) for mode in BOX_MODES
    ]


def side_ways(size: Size) -> list[Way]:
    """For each box mode: the other wishes and views, classifiers, and the other unit of pairs."""
    ways = []
    for main in main_ways(size):
        for wish in WISHES:
            for view in VIEWS:
                habits = Habits(wish=wish, view=view)
                if habits != Habits():
                    ways.append(Way(f"{main.name}: {wish}, {view}", main.settings, habits))
        for classifier in ("majority", "per_element"):
            settings = replace(main.settings, classifier=classifier)
            ways.append(Way(f"{main.name}: {classifier}", settings))
        settings = replace(main.settings, pair_unit="snapshot")
        ways.append(Way(f"{main.name}: snapshot", settings))
    return ways


def changes(size: Size) -> dict[str, tuple[Habits, HallSpec]]:
    """Habits and hall with each of the six strongest parameters halved and doubled, by name."""
    hall = PRESETS[size.scale]
    return {
        f"{what}, {word}": vary(what, factor, Habits(), hall)
        for what in STRONGEST
        for word, factor in FACTORS.items()
    }


def plan_learning(size: Size) -> list[LearnPiece]:
    """Every learning run."""
    hall = PRESETS[size.scale]
    pieces = [
        LearnPiece(way, BASE, way.habits, hall, size.scale, seed)
        for ways, runs in ((main_ways(size), size.runs), (side_ways(size), size.side_runs))
        for way in ways
        for seed in range(size.first_run, size.first_run + runs)
    ]
    default = main_ways(size)[0]
    return pieces + [
        LearnPiece(default, change, habits, spec, size.scale, seed)
        for change, (habits, spec) in changes(size).items()
        for seed in range(size.first_run, size.first_run + size.side_runs)
    ]


def plan_trials(size: Size) -> list[TrialPiece]:
    """Every set of trials."""
    return [*_plan_fixed(size), *_plan_learned(size), *_plan_changed_displays(size)]


def _plan_fixed(size: Size) -> Iterator[TrialPiece]:
    """Displays, controls and workers that nobody taught."""
    rest = (Habits(), PRESETS[size.scale], size.scale, size.first_seed, size.trials)
    for condition in (*DISPLAYS, *CONTROLS):
        yield TrialPiece(condition, BASE, condition, BELIEVER, *rest)
    for worker in WORKERS:
        yield TrialPiece(f"{worker} worker", BASE, "none", worker, *rest)


def _plan_learned(size: Size) -> Iterator[TrialPiece]:
    """P2 to P6 of the main ways, P6 of all others. P1 shows what `full` shows."""
    steps = points(size)
    mains = [way.name for way in main_ways(size)]
    before = size.first_run + size.early_runs
    for run in plan_learning(size):
        main = run.way.name in mains and run.change == BASE
        trials = size.trials if main else size.side_trials
        for number, step in enumerate(steps[1:], 2):
            if number == len(steps) or (main and run.seed < before):
                yield TrialPiece(
                    f"P{number} {run.way.name}", run.change, "varil", BELIEVER, run.habits,
                    run.hall, run.scale, size.first_seed, trials, run, step,
                )  # fmt: skip


def _plan_changed_displays(size: Size) -> Iterator[TrialPiece]:
    """The two reference displays again where a change concerns the worker or the hall."""
    for change, (habits, hall) in changes(size).items():
        if concerns_worker(change):
            for condition in DISPLAYS[:2]:
                yield TrialPiece(
                    condition, change, condition, BELIEVER, habits, hall, size.scale,
                    size.first_seed, size.side_trials,
                )  # fmt: skip


def concerns_worker(change: str) -> bool:
    """Whether a change touches trials without an expert."""
    what = change.rpartition(", ")[0]
    return what == WALKING_SPEED or any(name.startswith("worker.") for name in STRONGEST[what])
