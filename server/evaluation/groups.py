"""Which trials belong together: displays, controls, and policies by the iterations behind them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from server.evaluation.reading import TIMES, LearnedRun, TrialSet
from study.analysis.paired import Group
from study.errors import InvalidValue
from study.learning.policy import Policy
from study.people.worker import BELIEVER

POINTS = (0, 50, 100, 150, 200, 240)
"""P1 to P6: the policies after so many of 240 iterations [our choice: the paper says every 50]."""

DISPLAYS = ("arroch", "crmiar", "none", "full")
_RUN_OF_ITS_OWN = frozenset({"seed", "iteration"})


@dataclass(frozen=True)
class Label:
    """How a group is named. kind: learned, display, control or worker; rank sorts within kinds.

    `way`: how it was learned, as far as several ways are compared.
    """

    name: str
    kind: str
    rank: int
    way: str = ""


@dataclass(frozen=True)
class Trials:
    """One group for each of `TIMES`, and how many trials ended at their cap."""

    label: Label
    groups: Mapping[str, Group]
    timed_out: int

    @property
    def count(self) -> int:
        """Number of trials."""
        return sum(len(run) for run in self.groups[TIMES[0]].runs.values())


def name_point(iteration: int, iterations: int) -> str:
    """P1 to P6, or “after n iterations” for other policies."""
    if iterations == POINTS[-1] and iteration in POINTS:
        return f"P{POINTS.index(iteration) + 1}"
    return f"after {iteration} iterations"


def flatten_settings(settings: Mapping[str, Any]) -> dict[str, str]:
    """What runs may differ in beside their seed, each by its name."""
    flat: dict[str, str] = {}
    for name, value in settings.items():
        if name in _RUN_OF_ITS_OWN:
            continue
        if isinstance(value, Mapping):
            flat |= {f"{name}.{key}": text for key, text in flatten_settings(value).items()}
        else:
            flat[name] = str(value)
    return flat


def way_of(policy: Policy) -> dict[str, Any]:
    """What a learned policy's file says about how it was learned, and from whom."""
    settings = (policy.training or {}).get("settings", {})
    return dict(settings) | {"origin": policy.origin}


def name_ways(many: Iterable[Mapping[str, Any]]) -> dict[frozenset[tuple[str, str]], str]:
    """Name each way of learning by the settings that differ between them; "" if there is one."""
    ways = list(dict.fromkeys(frozenset(flatten_settings(one).items()) for one in many))
    shared = frozenset.intersection(*ways) if ways else frozenset()
    return {way: ", ".join(value for _, value in sorted(way - shared)) for way in ways}


def check_one_world(sets: Sequence[TrialSet], learned: Sequence[LearnedRun]) -> list[str]:
    """Refuse what cannot be compared; return notes on what is odd.

    Errors: InvalidValue for trials of several scales or of several settings of hall and people.
    """
    _one_of({entry.folder: entry.scale for entry in sets}, "scales")
    _one_of({run.folder: str(run.settings.get("scale")) for run in learned}, "scales")
    _one_of({entry.folder: entry.config_hash for entry in sets}, "settings of hall or people")
    if sets and learned and sets[0].scale != learned[0].settings.get("scale"):
        was = learned[0].settings.get("scale")
        return [f"Policies were learned at scale {was}, trials run at scale {sets[0].scale}."]
    return []


def group_trials(sets: Sequence[TrialSet]) -> list[Trials]:
    """Put trials with one label together, learned policies first, runs by their learning seed.

    Errors: InvalidValue where one run and seed has two different results.
    """
    ways = name_ways(
        way_of(entry.policy) for entry in sets if entry.policy and entry.policy.training
    )
    runs: dict[Label, dict[str, dict[str, dict[int, float]]]] = {}
    timed_out: dict[Label, int] = {}
    for entry in sets:
        label, run = _label(entry, ways)
        kept = runs.setdefault(label, {name: {} for name in TIMES})
        for name in TIMES:
            _add(kept[name].setdefault(run, {}), entry.times[name], entry.folder)
        timed_out[label] = timed_out.get(label, 0) + entry.timed_out
    order = ("learned", "display", "control", "worker")
    labels = sorted(runs, key=lambda label: (order.index(label.kind), label.way, label.rank))
    return [
        Trials(
            label,
            {name: Group(label.name, runs[label][name]) for name in TIMES},
            timed_out[label],
        )
        for label in labels
    ]


def _label(entry: TrialSet, ways: Mapping[frozenset[tuple[str, str]], str]) -> tuple[Label, str]:
    """The label of a set of trials, and the run that it belongs to."""
    if entry.worker != BELIEVER:
        return Label(f"{entry.worker} worker", "worker", 0), ""
    if entry.policy is None:
        rank = DISPLAYS.index(entry.condition) if entry.condition in DISPLAYS else len(DISPLAYS)
        return Label(entry.condition, "display", rank), ""
    policy = entry.policy
    if policy.origin == "initial":
        return Label("P1", "learned", 0), ""
    settings = way_of(policy)
    if "iteration" not in settings:
        return Label(policy.name, "control", 0), ""
    point = int(settings["iteration"])
    way = ways[frozenset(flatten_settings(settings).items())]
    name = name_point(point, int(settings.get("iterations", 0)))
    label = Label(f"{name} ({way})" if way else name, "learned", point, way)
    return label, str(settings.get("seed", ""))


def _add(kept: dict[int, float], fresh: Mapping[int, float], folder: Path) -> None:
    differing = [seed for seed in fresh if kept.get(seed, fresh[seed]) != fresh[seed]]
    if differing:
        raise InvalidValue(
            f"seed {differing[0]} was run twice with two different results",
            where=str(folder),
            next_step="Evaluate output of one version of the program at a time.",
        )
    kept.update(fresh)


def _one_of(values: Mapping[Path, str], what: str) -> None:
    """Refuse folders that differ, naming one folder for each value."""
    example = {value: folder for folder, value in values.items()}
    if len(example) > 1:
        listed = ", ".join(f"{value[:12]} ({folder})" for value, folder in sorted(example.items()))
        raise InvalidValue(
            f"the folders differ in their {what}: {listed}",
            next_step="Evaluate one of them at a time.",
        )
