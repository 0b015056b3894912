"""Headless trials: the same bits as a world stepped from outside, and workers that finish."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from server.headless.backends import Backend
from server.headless.trials import SimulationOptions, run_simulation
from study.errors import InvalidValue, UnknownCondition
from study.headless import simulate_many, simulate_trial
from study.people.patrols import PATROLS, Patrol
from study.records.tables import ROBOTS, TRIALS
from study.warehouse.layout import PRESETS, build_layout
from study.warehouse.world import World
from tests.study.warehouse.bodies import check_bodies

SUMMARY = [
    "trials",
    "completed",
    "timed_out",
    "overlaps",
    "longest_stall_s",
    "steps",
    "steps_per_s_per_core",
    "wall_s",
    "sum_wait_s_mean",
    "seed",
]


@pytest.mark.parametrize("worker", PATROLS)
def test_headless_equals_stepped(worker: str) -> None:
    """Guards exact replay: recorded inputs, fed to a world tick by tick, give the same state."""
    layout = build_layout(PRESETS["small"])
    trial = simulate_trial(layout, 21, worker, keep_inputs=True)
    assert trial.inputs is not None
    replayed = World(layout, 21)
    for keys, yaw in trial.inputs.tolist():
        replayed.step([(keys, yaw)])
    assert replayed.state_hash() == trial.state_hash
    assert replayed.measures() == trial.measures
    outside = World(layout, 21)
    patrol = Patrol(worker, outside.floor, outside.motion, 21)
    while outside.status == "running":
        outside.step([patrol.next_frame()])
    assert outside.state_hash() == trial.state_hash


@pytest.mark.parametrize("scale", list(PRESETS))
@pytest.mark.parametrize("worker", PATROLS)
def test_trials_complete(scale: str, worker: str) -> None:
    """Guards the promise of motion: nothing lost, no overlap, no stall of 60 s, at every scale."""
    spec = PRESETS[scale]
    for trial in simulate_many(build_layout(spec), range(2000, 2003), worker):
        measures = trial.measures
        assert measures.status == "completed"
        assert measures.boxes_delivered == spec.boxes_total
        assert measures.overlaps == 0
        assert measures.longest_stall_s < 60


def test_overlaps_and_boxes_recomputed_from_a_replay() -> None:
    """Guards the kernel's own count of overlaps and boxes, apart from it, at study scale."""
    layout = build_layout(PRESETS["study"])
    trial = simulate_trial(layout, 77, "wanderer", keep_inputs=True)
    assert trial.inputs is not None
    world = World(layout, 77)
    delivered = []
    for tick, frame in enumerate(trial.inputs.tolist()):
        events = world.step([(frame[0], frame[1])])
        delivered += [event.robot for event in events if event.kind == "box_delivered"]
        if tick % 6 == 0:
            check_bodies(world)
    assert sorted(delivered) == sorted(list(range(12)) * 3)


def test_unknown_worker_is_named() -> None:
    """Guards the error for a wrong worker."""
    with pytest.raises(InvalidValue, match="cyclic, wanderer, blocker"):
        simulate_trial(build_layout(PRESETS["practice"]), 1, "lazy")


def test_simulation_writes_its_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Guards the summary's keys and the tables' columns and rows, over two processes."""
    monkeypatch.setenv("VARIL_CACHE_DIR", str(Path(__file__).parents[2] / "var" / "kernels"))
    options = SimulationOptions(
        out=tmp_path / "out",
        scale="practice",
        trials=4,
        seed=30,
        backend=Backend(processes=2),
        quiet=True,
    )
    summary = run_simulation(options)
    assert list(summary) == SUMMARY
    assert (summary["trials"], summary["completed"], summary["overlaps"]) == (4, 4, 0)
    with (options.out / "trials.csv").open() as file:
        trials = list(csv.DictReader(file))
    assert list(trials[0]) == TRIALS.header
    assert [row["seed"] for row in trials] == ["30", "31", "32", "33"]
    assert sum(int(row["ticks"]) for row in trials) == summary["steps"]
    with (options.out / "robots.csv").open() as file:
        robots = list(csv.DictReader(file))
    assert list(robots[0]) == ROBOTS.header
    assert [row["boxes_delivered"] for row in robots] == ["1"] * 4


def test_simulation_refuses_unknown_names(tmp_path: Path) -> None:
    """Guards that wrong names are refused before anything is compiled or written."""
    with pytest.raises(UnknownCondition):
        run_simulation(SimulationOptions(out=tmp_path / "out", condition="magic", quiet=True))
    with pytest.raises(InvalidValue, match="practice, small, study, large, lab"):
        run_simulation(SimulationOptions(out=tmp_path / "out", scale="huge", quiet=True))
    assert not (tmp_path / "out").exists()
