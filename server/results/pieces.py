"""Runs the pieces of `make results`, each in a folder of its own, and never one twice.

A folder is named by a hash over everything that determines its contents: settings, people, hall,
seeds, sources and libraries. It appears whole, by renaming, once the piece is done, so an
interrupted run goes on where it stopped.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

import study
from server.evaluation.reading import POLICIES
from server.headless.backends import Backend
from server.headless.learning import LearningOptions, describe_policy, write_discrepancies
from server.headless.trials import POLICY_FILE, SimulationOptions, write_tables
from server.kernel_cache import open_kernel_cache
from server.policy_files import read_policy_file
from server.results.plan import LearnPiece, Size, TrialPiece, points
from study.headless import simulate_many
from study.learning.controls import CONTROLS, control_policy
from study.learning.discrepancies import measure
from study.learning.policy import Policy
from study.people.learning_run import run_learning
from study.people.worker import BELIEVER
from study.warehouse.layout import build_layout

EXPERT = "person"
SOURCES = ("warehouse", "ar", "learning", "people")
LIBRARIES = ("numpy", "numba", "scikit-learn")
LINE_EVERY = 10


@dataclass(frozen=True)
class Store:
    """Where pieces are kept, and the code that they are made by."""

    folder: Path
    code: str

    def place(self, piece: LearnPiece | TrialPiece) -> Path:
        """The folder of a piece, there or not yet."""
        described = {"code": self.code, **describe_piece(piece)}
        text = json.dumps(described, sort_keys=True, separators=(",", ":"))
        return self.folder / hashlib.sha256(text.encode()).hexdigest()[:20]


@dataclass(frozen=True)
class PieceWork:
    """Makes one piece in a worker process; called with the piece."""

    store: Store
    steps: tuple[int, ...]

    def __call__(self, piece: LearnPiece | TrialPiece) -> Path:
        """Make the piece unless it is there; return its folder."""
        place = self.store.place(piece)
        if place.is_dir():
            return place
        open_kernel_cache()
        fresh = place.with_name(f"{place.name}.{os.getpid()}")
        shutil.rmtree(fresh, ignore_errors=True)
        fresh.mkdir(parents=True)
        if isinstance(piece, LearnPiece):
            _learn(piece, fresh, self.steps)
        else:
            _simulate(piece, fresh, self.store)
        fresh.rename(place)
        return place


def run_pieces(
    pieces: Sequence[LearnPiece | TrialPiece],
    what: str,
    store: Store,
    size: Size,
    backend: Backend,
    console: Console,
) -> None:
    """Make all pieces that are not there yet, and show how far it is."""
    missing = [piece for piece in pieces if not store.place(piece).is_dir()]
    ready = len(pieces) - len(missing)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    progress = Progress(
        *columns, TimeRemainingColumn(), console=console, disable=not console.is_terminal
    )
    if not console.is_terminal:
        console.print(f"{what}: {len(pieces)} pieces, {ready} of them there already")
    with progress:
        bar = progress.add_task(what, total=len(pieces), completed=ready)
        work = PieceWork(store, points(size))
        for number, _ in enumerate(backend.run(work, missing), 1):
            progress.advance(bar)
            if not console.is_terminal and number % LINE_EVERY == 0:
                console.print(f"{what}: {ready + number} of {len(pieces)}")


def describe_piece(piece: LearnPiece | TrialPiece) -> dict[str, Any]:
    """Everything that a piece's result depends on, beside the code; names do not count."""
    common = {"hall": piece.hall.to_json(), "habits": piece.habits.to_json()}
    if isinstance(piece, LearnPiece):
        settings = piece.settings.to_json() | {"thresholds": piece.settings.thresholds.to_json()}
        return common | {"learn": settings}
    learned = describe_piece(piece.learned) if piece.learned else None
    return common | {
        "simulate": [piece.condition, piece.worker, piece.first_seed, piece.trials],
        "learned": learned,
        "iteration": piece.iteration,
    }


def hash_code() -> str:
    """16 hex digits over the sources and libraries that results depend on."""
    digest = hashlib.sha256()
    root = Path(study.__file__).parent
    files = [root / "headless.py"]
    for room in SOURCES:
        files += sorted([*(root / room).glob("*.py"), *(root / room).glob("*.toml")])
    for file in files:
        digest.update(f"{file.relative_to(root).as_posix()}\0".encode())
        digest.update(file.read_bytes())
    for name, version in library_versions().items():
        digest.update(f"\0{name} {version}".encode())
    return digest.hexdigest()[:16]


def library_versions() -> Mapping[str, str]:
    """The libraries whose version can change a bit of a result."""
    return {name: importlib.metadata.version(name) for name in LIBRARIES}


def _learn(piece: LearnPiece, out: Path, steps: Sequence[int]) -> None:
    """Run PolicyUp; keep its discrepancies and the policies P1 to P6."""
    options = LearningOptions(
        out,
        settings=piece.settings,
        scale=piece.scale,
        hall=piece.hall,
        habits=piece.habits,
        expert=EXPERT,
        worker=BELIEVER,
    )
    layout = build_layout(piece.hall)
    up = run_learning(
        options.settings, layout, options.worker, options.expert, habits=options.habits
    )
    found = measure(up.dataset, options.settings.iterations)
    write_discrepancies(out / "discrepancies.csv", found)
    (out / POLICIES).mkdir()
    for version in up.versions:
        if version.iterations in steps:
            policy = describe_policy(version, options, found["policy"])
            file = out / POLICIES / f"{version.iterations:03}.json"
            file.write_text(policy.to_json(), encoding="utf-8")


def _simulate(piece: TrialPiece, out: Path, store: Store) -> None:
    """Run the trials of a piece one after the other."""
    policy = _find_policy(piece, store)
    condition = "varil" if policy else piece.condition
    layout = build_layout(piece.hall)
    seeds = range(piece.first_seed, piece.first_seed + piece.trials)
    what = (piece.worker, condition, policy, piece.habits)
    finished = list(simulate_many(layout, seeds, *what))
    options = SimulationOptions(
        out,
        condition=condition,
        policy=policy,
        scale=piece.scale,
        hall=piece.hall,
        habits=piece.habits,
        worker=piece.worker,
    )
    sha256 = policy.sha256 if policy else ""
    write_tables(options, piece.hall, sha256, finished, with_robots=False)
    if policy is not None:
        (out / POLICY_FILE).write_text(policy.to_json(), encoding="utf-8")


def _find_policy(piece: TrialPiece, store: Store) -> Policy | None:
    if piece.learned is not None:
        folder = store.place(piece.learned) / POLICIES
        return read_policy_file(folder / f"{piece.iteration:03}.json")
    return control_policy(piece.condition) if piece.condition in CONTROLS else None
