"""Guards PolicyUp: snapshots, iterations inside them, the decision rule, masks and labels."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from study.errors import InvalidValue, JournalError
from study.learning.boxes import Checkboxes
from study.learning.dataset import Dataset
from study.learning.policy_up import PolicyUp, Version
from study.learning.settings import LearningSettings
from study.learning.training import Tables, TrainingOrder, initial_tables, train_tables
from tests.study.learning.moments import BLANK, ROBOTS, STATIONS, moment


def new_run(**settings: object) -> PolicyUp:
    """A run whose training counts only: the policy after j iterations shows j everywhere."""

    up = PolicyUp(LearningSettings(**settings), ROBOTS, STATIONS, count)  # type: ignore[arg-type]
    up.begin_trial(5)
    return up


def count(order: TrainingOrder) -> Tables:
    """The training of `new_run`."""
    return tuple((order.latest[0][0] - 1) % 8 for _ in order.latest[0]), order.latest[1]


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


def defer(up: PolicyUp) -> PolicyUp:
    """The same run with training elsewhere."""
    up.train = None
    return up


def test_an_order_is_frozen_and_the_next_iteration_begins_with_the_old_policy() -> None:
    """Pair 26 and on are of iteration 1 but still meet version 0; the order holds 25 pairs."""
    up = defer(new_run())
    watch(up, 360)
    assert [pair.iteration for pair in up.dataset] == [0] * 25 + [1] * 5
    assert {pair.proposal for pair in up.dataset if pair.domain == 0} == {7}
    (order,) = up.orders
    assert (order.iteration, sum(int(c.sum()) for c in order.counts)) == (1, 25)
    assert order.data_sha256 == Dataset(up.dataset.pairs[:25]).sha256()
    up.install(Version(1, count(order), order.data_sha256))
    assert up.orders == []
    up.attend(moment(390), BLANK)
    assert up.boxes.proposals[:ROBOTS] == [6] * ROBOTS


def test_a_deferred_run_is_complete_with_its_last_policy() -> None:
    up = defer(new_run(iterations=2))
    watch(up, 1200)
    assert (up.finished, up.complete, len(up.orders)) == (True, False, 2)
    for order in tuple(up.orders):
        up.install(Version(order.iteration, order.latest, order.data_sha256))
    assert up.complete


def test_versions_are_installed_in_order_only() -> None:
    up = defer(new_run())
    watch(up, 700)
    with pytest.raises(JournalError, match="version 2 cannot follow version 0"):
        up.install(Version(2, up.latest, ""))
    with pytest.raises(JournalError, match="version 9"):
        up.install(Version(9, up.latest, ""))


def test_no_pairs_while_nobody_records() -> None:
    up = new_run()
    up.is_recording = False
    watch(up, 240)
    assert len(up.dataset) == 0
    up.is_recording = True
    watch(up, 120)
    assert len(up.dataset) == 10


@pytest.mark.parametrize("owed", [0, 1, 2])
def test_a_run_read_back_goes_on_like_the_one_that_was_written(owed: int) -> None:
    """With D and versions beside it the state holds everything, trainings that are owed too."""
    up = defer(new_run(box_mode="independent", beta="exponential(0.9)"))
    watch(up, 700)
    up.boxes.set(3, 2, tick=700)
    for order in tuple(up.orders)[: len(up.orders) - owed]:
        up.install(Version(order.iteration, count(order), order.data_sha256))
    up.begin_trial(77)
    other = PolicyUp(up.settings, ROBOTS, STATIONS, train=None)
    other.load(json.loads(json.dumps(up.to_json())), Dataset(up.dataset), list(up.versions))
    for run in (up, other):
        watch(run, 1200)
    assert other.dataset.pairs == up.dataset.pairs
    assert other.boxes.to_json() == up.boxes.to_json()
    assert other.by_expert.tolist() == up.by_expert.tolist()
    assert other.to_json() == up.to_json()
    assert [_plain(order) for order in other.orders] == [_plain(order) for order in up.orders]


def _plain(order: TrainingOrder) -> tuple[object, ...]:
    counts = [part.tolist() for part in order.counts]
    return order.iteration, counts, order.classifier, order.data_sha256


def test_state_of_another_run_is_refused() -> None:
    up = defer(new_run())
    watch(up, 360)
    record = up.to_json()
    for data, versions in ((Dataset(), up.versions), (up.dataset, up.versions * 2)):
        with pytest.raises(JournalError, match="do not fit"):
            PolicyUp(up.settings, ROBOTS, STATIONS, None).load(record, data, versions)
    with pytest.raises(JournalError, match=r"boxes\.masks"):
        PolicyUp(up.settings, 3, STATIONS, None).load(record, up.dataset, up.versions)


def test_a_kind_without_pairs_keeps_its_table() -> None:
    order = TrainingOrder(1, Dataset().counts, initial_tables(), "svm", "")
    assert train_tables(order) == initial_tables()


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
