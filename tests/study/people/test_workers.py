"""Guards the oracle, habits that are handed over by hand, and the controls."""

from __future__ import annotations

import numpy as np
import pytest

from study.errors import InvalidValue, LayoutError
from study.headless import simulate_trial
from study.learning.controls import CONTROLS, control_policy
from study.learning.policy import read_policy
from study.people.habits import Habits
from study.people.parameters import parameters_of
from study.people.sensitivity import STRONGEST, WALKING_SPEED, vary
from study.warehouse.layout import PRESETS, build_layout

SMALL = build_layout(PRESETS["small"])


def states_of(
    worker: str, habits: Habits | None = None, condition: str = "full", name: str | None = None
) -> tuple[bytes, ...]:
    """The last states of a few trials. One trial alone may not meet what a parameter changes."""
    policy = control_policy(name) if name else None
    what = {"condition": condition, "policy": policy, "habits": habits}
    return tuple(simulate_trial(SMALL, seed, worker, **what).state_hash for seed in range(4, 9))


@pytest.mark.parametrize("scale", list(PRESETS))
def test_the_oracle_completes_trials(scale: str) -> None:
    layout = build_layout(PRESETS[scale])
    for seed in range(3):
        measures = simulate_trial(layout, seed, "oracle").measures
        assert measures.status == "completed"
        assert measures.overlaps == 0
        assert measures.longest_stall_s < 60


def test_the_oracle_reads_nothing() -> None:
    """It acts on the truth: no display, and no trust in balloons, can change what it does."""
    hashes = {states_of("oracle", None, condition) for condition in ("none", "arroch", "crmiar")}
    hashes.add(states_of("oracle", Habits(balloon_belief="always")))
    assert len(hashes) == 1


def test_knowing_the_truth_helps() -> None:
    """Over common seeds robots wait less for the oracle than for who sees no display."""
    layout = build_layout(PRESETS["study"])
    waits = {
        worker: [simulate_trial(layout, n, worker).measures.sum_wait_s for n in range(15)]
        for worker in ("oracle", "believer")
    }
    assert np.mean(waits["oracle"]) < np.mean(waits["believer"])


def test_habits_change_the_believer_and_leave_nothing_behind() -> None:
    """Each strongest parameter of the worker matters; a call without habits has the defaults."""
    default = states_of("believer")
    for habits in (
        Habits(balloon_belief="always"),
        Habits().scaled(["worker.decide_s"], 2.0),
        Habits().scaled(["worker.walking_factor"], 0.5),
    ):
        assert states_of("believer", habits) != default
    assert states_of("believer") == default == states_of("believer", Habits())
    assert parameters_of("worker")["decide_s"] == 1.35


def test_scaling_stays_within_limits() -> None:
    habits = Habits().scaled(["worker.walking_factor", "expert.near_m"], 2.0)
    assert habits.values_of("worker")["walking_factor"] == 1.0
    assert habits.values_of("expert")["near_m"] == 12.0
    assert habits.scaled(["expert.near_m"], 0.5).values_of("expert") == parameters_of("expert")
    assert Habits().scaled(["worker.walking_look_s"], 0.0).values_of("worker")["walking_look_s"] > 0


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"wish": "please"}, "declutter, inform"),
        ({"view": "below"}, "worker, above"),
        ({"balloon_belief": "never"}, "onset, always"),
        ({"replaced": (("worker.luck", 1.0),)}, "no parameter “worker.luck”"),
        ({"replaced": (("version.x", 1.0),)}, "no parameter “version.x”"),
        ({"replaced": (("worker.notice", 1.5),)}, "worker.notice: 1.5 is not allowed"),
        ({"replaced": (("worker.decide_s", float("nan")),)}, "worker.decide_s: nan"),
        ({"replaced": (("worker.decide_s", -1.0),)}, "worker.decide_s: -1.0"),
    ],
)
def test_wrong_habits_are_named(given: dict[str, object], sentence: str) -> None:
    with pytest.raises(InvalidValue, match=sentence):
        Habits(**given)


def test_each_strongest_parameter_can_be_varied() -> None:
    """All six exist under their names, and each changes habits or hall, never both."""
    assert len(STRONGEST) == 6
    for what in STRONGEST:
        for factor in (0.5, 2.0):
            habits, spec = vary(what, factor, Habits(), PRESETS["study"])
            assert (habits != Habits()) == (what != WALKING_SPEED)
            assert (spec.human_speed_mps != 1.4) == (what == WALKING_SPEED)
    with pytest.raises(InvalidValue, match="walking speed"):
        vary("luck", 2.0, Habits(), PRESETS["study"])
    with pytest.raises(LayoutError, match="human_speed_mps"):
        vary(WALKING_SPEED, 9.0, Habits(), PRESETS["study"])


def test_controls_show_what_they_say() -> None:
    """`all_off` is the empty display; `no_ghost` is neither that nor ARROCH; files hold them."""
    states = {name: states_of("believer", None, "varil", name) for name in CONTROLS}
    for name in CONTROLS:
        policy = control_policy(name)
        assert read_policy(policy.to_json()) == policy
        assert policy.origin == "control"
    assert states["all_off"] == states_of("believer", None, "none")
    assert states["no_ghost"] not in {states_of("believer", None, "arroch"), states["all_off"]}
    assert set(control_policy("no_ghost").robot_table) == {5}
    with pytest.raises(InvalidValue, match="all_off, no_ghost"):
        control_policy("half_off")
