"""Guards PolicyUp: snapshots, iterations inside them, the decision rule, masks and labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from study.ar.elements import Display
from study.ar.situation import Situation
from study.errors import InvalidValue
from study.learning.boxes import Checkboxes
from study.learning.dataset import Dataset
from study.learning.policy_up import PolicyUp, Tables, initial_tables, train_tables
from study.learning.settings import LearningSettings
from study.warehouse.layout import PRESETS, build_layout

LAYOUT = build_layout(PRESETS["small"])
ROBOTS, STATIONS = 6, 4
BLANK = Display.nothing(ROBOTS, STATIONS)


def moment(tick: int, state: Sequence[int] = (0,) * ROBOTS) -> Situation:
    """A world by hand: `state` of each robot; the waiting ones stand at station 1."""
    return Situation(
        layout=LAYOUT,
        tick=tick,
        human_x_m=6.0,
        human_y_m=1.0,
        robot_x_m=np.linspace(1.0, 11.0, ROBOTS),
        robot_y_m=np.full(ROBOTS, 2.0),
        robot_state=np.array(state, np.int8),
        robot_carrying=np.full(ROBOTS, -1, np.int8),
        robot_station=np.full(ROBOTS, 1, np.int8),
        robot_remaining=np.full(ROBOTS, 3, np.int64),
        robot_wait_s=np.zeros(ROBOTS),
    )


def new_run(**settings: object) -> PolicyUp:
    """A run whose training counts only: the policy after j iterations shows j everywhere."""

    def count(dataset: Dataset, latest: Tables, classifier: str) -> Tables:
        del dataset, classifier
        return tuple((latest[0][0] - 1) % 8 for _ in latest[0]), latest[1]

    up = PolicyUp(LearningSettings(**settings), ROBOTS, STATIONS, count)  # type: ignore[arg-type]
    up.begin_trial(5)
    return up


def watch(up: PolicyUp, ticks: int, state: Sequence[int] = (0,) * ROBOTS) -> None:
    for tick in range(0, ticks + 1, 30):
        if not up.finished:
            up.attend(moment(tick, state), BLANK)


def test_a_snapshot_every_four_seconds_in_fixed_order() -> None:
    up = new_run()
    watch(up, 239)
    assert [pair.tick for pair in up.dataset] == [120] * 10
    order = [(pair.domain, pair.agent) for pair in up.dataset]
    assert order == [(0, n) for n in range(ROBOTS)] + [(1, n) for n in range(STATIONS)]


def test_robots_at_home_give_no_pair() -> None:
    up = new_run()
    watch(up, 120, (0, 6, 0, 6, 6, 0))
    assert [pair.agent for pair in up.dataset if pair.domain == 0] == [0, 2, 5]


def test_the_twenty_fifth_pair_closes_the_iteration_inside_a_snapshot() -> None:
    """Pair 25 is the fifth of the third snapshot; the sixth meets the next policy at once."""
    up = new_run()
    watch(up, 360)
    pairs = list(up.dataset)
    assert [pair.iteration for pair in pairs] == [0] * 25 + [1] * 5
    assert [pair.proposal for pair in pairs[20:26]] == [7] * 5 + [6]
    assert pairs[25].box == 6, "a following box takes the new proposal"
    assert up.versions[1].data_sha256 != up.versions[0].data_sha256


def test_snapshots_as_units_close_after_25_of_them() -> None:
    up = new_run(pair_unit="snapshot", iterations=1)
    watch(up, 120 * 24)
    assert (up.j, up.units, len(up.dataset)) == (0, 24, 240)
    watch(up, 120 * 25)
    assert up.finished


def test_a_run_stops_at_exactly_its_pairs() -> None:
    up = new_run(iterations=3)
    watch(up, 5000)
    assert (up.finished, up.units, len(up.dataset), len(up.versions)) == (True, 75, 75, 4)


def test_undrawn_elements_enter_the_label_as_proposed() -> None:
    """A waiting robot has no path: of the expert's “nothing” only the live location is learned."""
    up = new_run()

    def hide(boxes: Checkboxes, states: Sequence[int]) -> None:
        for agent in range(len(states)):
            boxes.set(agent, 0, 0)

    for tick in (0, 30, 60, 90, 120):
        up.attend(moment(tick, (0, 3, 0, 0, 0, 0)), BLANK, hide)
    pairs = list(up.dataset)
    assert [(pair.drawn, pair.label) for pair in pairs[:2]] == [(7, 0), (1, 6)]
    assert [(pair.drawn, pair.label) for pair in pairs[6:]] == [(0, 1), (1, 0), (0, 1), (0, 1)]


def test_only_touched_agents_are_labelled_by_events_and_confirmations() -> None:
    for source, wanted in (("events", [2]), ("confirmed", [2, 4])):
        up = new_run(label_source=source)
        up.boxes.set(2, 1, tick=60)
        up.boxes.set(4, 7, tick=60)
        watch(up, 360)
        assert [pair.agent for pair in up.dataset if pair.tick == 120] == wanted
        assert [pair.agent for pair in up.dataset if pair.tick == 360] == [], "8 s have passed"


def test_the_decision_rule_is_drawn_for_each_agent_and_iteration() -> None:
    """At j = 0 the expert decides everywhere, at the end nearly nowhere; draws differ by agent."""
    up = new_run(iterations=40)
    rule = [up.by_expert.copy()]
    for tick in range(0, 30 * 120 * 40, 30):
        j = up.j
        up.attend(moment(tick), BLANK)
        if up.finished:
            break
        if up.j != j:
            rule.append(up.by_expert.copy())
    assert rule[0].all()
    shares = [np.mean(rule[a:b]) for a, b in ((0, 10), (15, 25), (30, 40))]
    assert shares[0] > 0.75 > 0.65 > shares[1] > 0.35 > 0.25 > shares[2]
    assert len({tuple(column) for column in np.array(rule).T}) == ROBOTS + STATIONS


def test_what_is_displayed_is_the_box_or_the_proposal() -> None:
    up = new_run(box_mode="independent")
    up.attend(moment(0), BLANK)
    up.boxes.set(0, 1, tick=0)
    up.boxes.set(6, 0, tick=0)
    up.by_expert = np.array([True] + [False] * 9)
    shown = up.decide(moment(0), BLANK)
    assert list(shown.robots) == [1, 7, 7, 7, 7, 7]
    assert list(shown.stations) == [1, 1, 1, 1]


def test_everything_carries_over_to_the_next_trial() -> None:
    up = new_run(box_mode="independent")
    watch(up, 300)
    up.boxes.set(0, 2, tick=300)
    up.begin_trial(6)
    up.attend(moment(0), BLANK)
    assert up.boxes.masks[0] == 2
    assert up.run_tick(30) == 330
    watch(up, 120)
    last = list(up.dataset)[-1]
    assert (last.trial, last.trial_seed, last.tick, up.units) == (1, 6, 120, 30)


def test_a_kind_without_pairs_keeps_its_table() -> None:
    assert train_tables(Dataset(), initial_tables(), "svm") == initial_tables()


def test_beta_schedules() -> None:
    linear = LearningSettings(iterations=4)
    assert [linear.beta_of(j) for j in range(4)] == [1.0, 0.75, 0.5, 0.25]
    exponential = replace(linear, beta="exponential(0.5)")
    assert [exponential.beta_of(j) for j in range(3)] == [1.0, 0.5, 0.25]
    first = replace(linear, beta="first_only")
    assert [first.beta_of(j) for j in range(3)] == [1.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("iterations", 0),
        ("iterations", True),
        ("seed", -1),
        ("beta", "exponential(2)"),
        ("beta", "cosine"),
        ("box_mode", "free"),
        ("label_source", "guess"),
        ("pair_unit", "hour"),
    ],
)
def test_wrong_settings_are_named(name: str, value: object) -> None:
    with pytest.raises(InvalidValue, match=name):
        LearningSettings(**{name: value})  # type: ignore[arg-type]
