"""Guards the believer: it finishes, it is exact, and it knows only what can be seen."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

from study.ar.conditions import CONDITIONS, build_condition
from study.ar.display import DisplayClock
from study.ar.display_kernels import new_shown, refresh
from study.ar.elements import Display
from study.ar.thresholds import Thresholds
from study.errors import InvalidValue, UnknownCondition
from study.headless import simulate_trial
from study.learning.policy import Policy
from study.people.beliefs import GONE, UNKNOWN
from study.people.looking import VIEW, in_sight, in_view
from study.people.parameters import parameters_of, read_parameters
from study.people.worker import Believer
from study.warehouse.layout import PRESETS, build_layout
from study.warehouse.world import World

PEOPLE = Path(__file__).parents[3] / "study" / "people"
DRAWS = np.random.default_rng(4)
POLICY = Policy(
    "mixed",
    "simulated",
    Thresholds(),
    tuple(DRAWS.integers(0, 8, 144).tolist()),
    tuple(DRAWS.integers(0, 2, 18).tolist()),
)


@pytest.mark.parametrize("condition", CONDITIONS)
def test_compiled_trial_equals_one_stepped_from_outside(condition: str) -> None:
    """One display and one worker, whether compiled as a whole or asked tick by tick."""
    layout = build_layout(PRESETS["small"])
    trial = simulate_trial(layout, 8, "believer", condition=condition, policy=POLICY)
    world = World(layout, 8)
    believer = Believer(world, 8)
    clock = DisplayClock(build_condition(condition, POLICY), 6, 4)
    clock.start(world)
    while world.status == "running":
        world.step([believer.next_frame(clock.display)])
        clock.update(world)
    assert world.state_hash() == trial.state_hash
    assert trial.measures.status == "completed"


def test_the_compiled_display_equals_the_clock() -> None:
    """Masks, balloons and holding times agree at every decision of a trial, state by state."""
    world = World(build_layout(PRESETS["study"]), 12)
    shown = new_shown(world.layout, "varil", POLICY)
    clock = DisplayClock(build_condition("varil", POLICY), 12, 4)
    clock.start(world)
    refresh(world.floor, world.motion, shown)
    seen = set()
    for _ in range(4000):
        world.step([(1 + world.tick // 200 % 2 * 8, world.tick * 40 & 65535)])
        clock.update(world)
        if world.tick % 30 == 0:
            refresh(world.floor, world.motion, shown)
            assert shown.robots.astype(np.uint8).tobytes() == clock.display.robots
            assert shown.stations.astype(np.uint8).tobytes() == clock.display.stations
            seen.add(clock.display)
    assert len(seen) > 20


@pytest.mark.parametrize("scale", list(PRESETS))
def test_trials_complete(scale: str) -> None:
    """It finds every robot at every scale, even when nothing is displayed."""
    layout = build_layout(PRESETS[scale])
    for condition in ("none", "crmiar"):
        for seed in range(5):
            measures = simulate_trial(layout, seed, "believer", condition=condition).measures
            assert measures.status == "completed"
            assert measures.overlaps == 0
            assert measures.longest_stall_s < 60


def test_the_display_changes_what_it_does() -> None:
    layout = build_layout(PRESETS["study"])
    hashes = {
        simulate_trial(layout, 3, "believer", condition=condition).state_hash
        for condition in ("none", "arroch", "crmiar", "full")
    }
    assert len(hashes) == 4


def test_hidden_robots_stay_unknown_without_a_display() -> None:
    """With nothing displayed, only robots in direct sight are believed in at the first look."""
    world = World(build_layout(PRESETS["study"]), 5)
    for _ in range(300):
        world.step([])
    blind, told = Believer(world, 1), Believer(world, 1)
    blind.next_frame(Display.nothing(12, 4))
    told.next_frame(Display(bytes([7] * 12), bytes(4)))
    believed = [int((one.memory.beliefs["kind"] != UNKNOWN).sum()) for one in (blind, told)]
    assert believed[0] < believed[1]
    assert not (told.memory.beliefs["kind"] == GONE).any()
    known = set(np.flatnonzero(blind.memory.beliefs["kind"] != UNKNOWN).tolist())
    assert known <= set(np.flatnonzero(blind.memory.sights).tolist())


def test_shelves_hide_and_the_view_has_edges() -> None:
    layout = build_layout(PRESETS["study"])
    world = World(layout, 1)
    view = np.zeros(1, dtype=VIEW)
    view["x"], view["y"], view["look_x"] = 3.3, 3.0, 1.0
    view["cosine"], view["sight_m"] = np.cos(np.pi / 4), 25.0
    x0, y0, x1, y1 = layout.shelves_m[0]
    view["x"], view["y"] = x0 - 0.9, (y0 + y1) / 2
    cells, stride = world.motion.cells, int(world.floor.hall["stride"][0])
    middle = float((y0 + y1) / 2)
    assert not in_sight(view[0], cells, float(x1 + 0.9), middle, stride)
    assert in_sight(view[0], cells, float(x0 - 0.4), middle, stride)
    assert in_view(view[0], float(x1 + 0.9), middle)
    assert not in_view(view[0], float(x0 - 2.0), middle)
    assert not in_view(view[0], float(x0), middle + 2.0)


def test_people_never_see_the_agents_states() -> None:
    """What simulated people do must not come from the discrete states; the table expert alone may,
    whose purpose is to test the algorithm."""
    for path in sorted(PEOPLE.glob("*.py")):
        if path.stem == "table_expert":
            continue
        modules = {
            node.module
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.ImportFrom)
        }
        forbidden = {"study.ar.states", "study.ar.state_names", "study.ar.state_kernels"}
        assert not modules & forbidden, path.name


def test_every_parameter_has_an_origin() -> None:
    assert parameters_of("worker")["decide_s"] == 1.35
    with pytest.raises(InvalidValue, match=r"worker\.decide_s: it says neither source nor reason"):
        read_parameters("[worker.decide_s]\nvalue = 1.0\n", "worker")
    with pytest.raises(InvalidValue, match="a value of at least 0"):
        read_parameters('[worker.decide_s]\nreason = "x"\n', "worker")
    with pytest.raises(InvalidValue, match="no parameters of “ghost”"):
        read_parameters("version = 1\n", "ghost")


def test_every_parameter_is_used() -> None:
    """A value in the file that nothing reads would promise an effect that it does not have."""
    code = "".join(path.read_text() for path in sorted(PEOPLE.glob("*.py")))
    for person in ("worker", "expert"):
        assert [name for name in parameters_of(person) if name not in code] == []


def test_a_display_without_its_policy_is_refused() -> None:
    layout = build_layout(PRESETS["practice"])
    with pytest.raises(UnknownCondition):
        simulate_trial(layout, 1, "believer", condition="varil")
    with pytest.raises(UnknownCondition):
        simulate_trial(layout, 1, "believer", condition="magic", policy=POLICY)
