"""The numbers of `make results`, from its finished pieces: one record, and the figures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from server.evaluation.reading import TIMES, read_learned, read_trials
from server.evaluation.run import BOOTSTRAP_SEED, stack_runs
from server.results.pieces import Store
from server.results.plan import (
    BASE,
    DISPLAYS,
    WORKERS,
    LearnPiece,
    Size,
    TrialPiece,
    changes,
    concerns_worker,
    main_ways,
    plan_learning,
    plan_trials,
    points,
    side_ways,
)
from study.analysis.claims import Fall, detectable_s, measure_fall
from study.analysis.intervals import Floats, Interval
from study.analysis.paired import Difference, Group, compare_groups, mean_of
from study.errors import InvalidValue
from study.learning.controls import CONTROLS

REFERENCES = DISPLAYS[:2]
Measured = Mapping[str, Group]


@dataclass(frozen=True)
class Mode:
    """One box mode. `falls[measure]`: VARIL's and ARROCH's; `shorter[reference][measure]`: P6
    minus the reference; `steps`: P1 to P6 with the difference to P1 (None for P1 itself)."""

    name: str
    found: Mapping[str, Mapping[str, Floats]]
    falls: Mapping[str, tuple[Fall, Fall]]
    shorter: Mapping[str, Mapping[str, Difference]]
    steps: Sequence[tuple[str, Interval, Difference | None]]


@dataclass(frozen=True)
class Side:
    """Another way of learning: P6 minus ARROCH, and where its discrepancies end."""

    name: str
    pair: Difference
    differing: float
    shown: float


@dataclass(frozen=True)
class Findings:
    """All that the report says. `means[group]`: of the sum of waits, on all seeds."""

    modes: Sequence[Mode]
    means: Mapping[str, Interval]
    controls: Mapping[str, Mapping[str, Difference]]
    sides: Sequence[Side]
    base: Difference
    changed: Mapping[str, Difference]
    waits: Mapping[str, Group]
    detectable_s: float
    timed_out: int


class Pieces:
    """The finished pieces by what they are about."""

    def __init__(self, size: Size, store: Store) -> None:
        self.size = size
        self._store = store
        self._learned: dict[tuple[str, str], list[LearnPiece]] = {}
        for run in plan_learning(size):
            self._learned.setdefault((run.way.name, run.change), []).append(run)
        self._groups: dict[tuple[str, str], dict[str, Group]] = {}
        self.timed_out = 0
        trials: dict[tuple[str, str], list[TrialPiece]] = {}
        for piece in plan_trials(size):
            trials.setdefault((piece.group, piece.change), []).append(piece)
        for what, pieces in trials.items():
            self._groups[what] = self._read(what[0], pieces)

    def curves(self, way: str, change: str = BASE) -> Mapping[str, Mapping[str, Floats]]:
        """Discrepancies of the runs of a way: float64[runs, J] by measure and line."""
        runs = self._learned[way, change]
        return stack_runs([read_learned(self._store.place(run)) for run in runs])

    def group(self, name: str, change: str = BASE, runs: int | None = None) -> Measured:
        """A group's measures; `runs`: only the first of them."""
        found = self._groups[name, change]
        if runs is None:
            return found
        return {
            measure: Group(name, dict(list(group.runs.items())[:runs]))
            for measure, group in found.items()
        }

    def _read(self, name: str, pieces: Iterable[TrialPiece]) -> dict[str, Group]:
        runs: dict[str, dict[str, Mapping[int, float]]] = {measure: {} for measure in TIMES}
        for piece in pieces:
            trials = read_trials(self._store.place(piece))
            self.timed_out += trials.timed_out
            for measure in TIMES:
                run = str(piece.learned.seed) if piece.learned else ""
                runs[measure][run] = trials.times[measure]
        return {measure: Group(name, runs[measure]) for measure in TIMES}


def collect_findings(size: Size, store: Store) -> Findings:
    """Compute everything from the pieces. Errors: those of a damaged piece, naming its file."""
    pieces = Pieces(size, store)
    modes = [_mode(way.name, pieces) for way in main_ways(size)]
    fixed = [*DISPLAYS, *CONTROLS, *(f"{worker} worker" for worker in WORKERS)]
    waits = {name: pieces.group(name)["sum_wait_s"] for name in fixed}
    for mode in modes:
        for name, _, _ in mode.steps[1:]:
            waits[f"{name} {mode.name}"] = pieces.group(f"{name} {mode.name}")["sum_wait_s"]
    seeds = sorted(waits["arroch"].seeds & waits["crmiar"].seeds)
    apart = waits["arroch"].table(seeds)[0] - waits["crmiar"].table(seeds)[0]
    return Findings(
        modes=modes,
        means={name: mean_of(group, BOOTSTRAP_SEED) for name, group in waits.items()},
        controls={
            name: {
                reference: _pair(waits[name], waits[reference])
                for reference in REFERENCES
                if name != reference
            }
            for name in fixed
        },
        sides=[_side(way.name, pieces) for way in side_ways(size)],
        base=_against(BASE, pieces),
        changed={change: _against(change, pieces) for change in changes(size)},
        waits=waits,
        detectable_s=detectable_s(apart),
        timed_out=pieces.timed_out,
    )


def _mode(name: str, pieces: Pieces) -> Mode:
    found = pieces.curves(name)
    first = pieces.group("full")["sum_wait_s"]
    steps: list[tuple[str, Interval, Difference | None]] = [
        ("P1", mean_of(first, BOOTSTRAP_SEED), None)
    ]
    for number in range(2, len(points(pieces.size)) + 1):
        group = pieces.group(f"P{number} {name}")["sum_wait_s"]
        mean = mean_of(group, BOOTSTRAP_SEED)
        steps.append((f"P{number}", mean, _pair(group, first)))
    last = pieces.group(f"P{len(steps)} {name}")
    return Mode(
        name=name,
        found=found,
        falls={
            measure: (
                measure_fall(lines["policy"], BOOTSTRAP_SEED),
                measure_fall(lines["arroch"], BOOTSTRAP_SEED),
            )
            for measure, lines in found.items()
        },
        shorter={
            reference: {
                measure: _pair(last[measure], pieces.group(reference)[measure]) for measure in TIMES
            }
            for reference in REFERENCES
        },
        steps=steps,
    )


def _side(name: str, pieces: Pieces) -> Side:
    found = pieces.curves(name)
    last = pieces.group(f"P{len(points(pieces.size))} {name}")["sum_wait_s"]
    ends = {
        measure: measure_fall(found[measure]["policy"], BOOTSTRAP_SEED).late
        for measure in ("hamming_rate", "shown_share")
    }
    pair = _pair(last, pieces.group("arroch")["sum_wait_s"])
    return Side(name, pair, ends["hamming_rate"], ends["shown_share"])


def _against(change: str, pieces: Pieces) -> Difference:
    """P6 of the default way minus ARROCH with a parameter changed, on the side runs' seeds."""
    name = f"P{len(points(pieces.size))} {main_ways(pieces.size)[0].name}"
    ours = pieces.group(name, change, pieces.size.side_runs)["sum_wait_s"]
    their_change = change if change != BASE and concerns_worker(change) else BASE
    theirs = pieces.group("arroch", their_change)["sum_wait_s"]
    side = frozenset(sorted(theirs.seeds)[: pieces.size.side_trials])
    return _pair(_only(ours, side), _only(theirs, side))


def _only(group: Group, seeds: frozenset[int]) -> Group:
    runs = {
        name: {seed: value for seed, value in run.items() if seed in seeds}
        for name, run in group.runs.items()
    }
    return Group(group.name, runs)


def _pair(ours: Group, theirs: Group) -> Difference:
    found = compare_groups(ours, theirs, BOOTSTRAP_SEED)
    if found is None:
        raise InvalidValue(
            f"“{ours.name}” and “{theirs.name}” have no seed in common",
            next_step="Delete the folder of pieces and run `make results` again.",
        )
    return found
