"""Guards classifiers: their contract, and that weighted different rows train like all rows."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from sklearn.svm import SVC

from study.errors import InvalidValue
from study.learning.classifiers import CLASSIFIERS, Cases, Majority, choose_classifier
from study.learning.dataset import Pair
from study.learning.domains import DOMAINS, ROBOT_DOMAIN, STATION_DOMAIN, Domain
from study.learning.examination import ClassifierFailed, examine_classifier
from study.learning.settings import LearningSettings
from study.people.learning_run import run_learning
from study.warehouse.layout import PRESETS, build_layout

Ints = npt.NDArray[np.int64]


def noisy_rows(domain: Domain, seed: int, rows: int) -> tuple[Ints, Ints]:
    """Rows as a run makes them: some states often, a rule with slips."""
    draws = np.random.default_rng(seed)
    rule = draws.integers(0, domain.actions, 6)
    states = (draws.beta(0.6, 1.4, rows) * domain.states).astype(np.int64)
    slips = draws.random(rows) < 0.2
    actions = np.where(slips, draws.integers(0, domain.actions, rows), rule[states % 6])
    return states, actions


def counted(domain: Domain, states: Ints, actions: Ints) -> Cases:
    counts = np.zeros((domain.states, domain.actions), np.int64)
    np.add.at(counts, (states, actions), 1)
    return Cases.from_counts(counts)


@pytest.mark.parametrize("name", CLASSIFIERS)
def test_every_classifier_passes_its_examination(name: str) -> None:
    examine_classifier(CLASSIFIERS[name])


def test_the_examination_notices_a_forgetful_classifier() -> None:
    """A classifier that ignores a single class must fail, or the examination guards nothing."""

    class Zero:
        def train(self, domain: Domain, cases: Cases) -> Ints:
            return np.zeros(domain.states, np.int64)

    with pytest.raises(ClassifierFailed, match="one class"):
        examine_classifier(Zero())


@pytest.mark.parametrize("domain", DOMAINS, ids=lambda domain: domain.name)
@pytest.mark.parametrize("seed", range(4))
def test_weighted_different_rows_train_like_all_rows(domain: Domain, seed: int) -> None:
    """The table equals that of scikit-learn's own machine, untouched by us, over all rows."""
    states, actions = noisy_rows(domain, seed, 1500)
    plain = SVC(kernel="rbf", C=1.0).fit(domain.features[states], actions)
    table = CLASSIFIERS["svm"].train(domain, counted(domain, states, actions))
    assert table.tolist() == plain.predict(domain.features).tolist()


def test_a_real_run_trains_like_all_its_rows() -> None:
    """The policies of a learning run equal those of scikit-learn's own machine over every pair."""
    settings = LearningSettings(iterations=60, seed=4)
    up = run_learning(settings, build_layout(PRESETS["small"]), "cyclic", "person")
    columns = up.dataset.columns()
    kinds, states, labels = (
        columns[:, Pair._fields.index(name)] for name in ("domain", "state", "label")
    )
    for at in (25, 60):
        closed = columns[:, Pair._fields.index("iteration")] < at
        for number, domain in enumerate(DOMAINS):
            rows = closed & (kinds == number)
            plain = SVC(kernel="rbf", C=1.0).fit(domain.features[states[rows]], labels[rows])
            expected = plain.predict(domain.features).tolist()
            assert list(up.versions[at].tables[number]) == expected


def test_per_element_is_one_machine_for_each_bit() -> None:
    states, actions = noisy_rows(ROBOT_DOMAIN, 9, 800)
    table = CLASSIFIERS["per_element"].train(ROBOT_DOMAIN, counted(ROBOT_DOMAIN, states, actions))
    for bit in range(3):
        plain = SVC(kernel="rbf", C=1.0).fit(ROBOT_DOMAIN.features[states], actions >> bit & 1)
        assert (table >> bit & 1).tolist() == plain.predict(ROBOT_DOMAIN.features).tolist()


def test_majority_takes_the_most_frequent_action() -> None:
    cases = Cases(np.array([0, 1, 2]), np.array([4, 4, 7]), np.array([2, 3, 6]))
    assert set(Majority().train(ROBOT_DOMAIN, cases).tolist()) == {7}


def test_costs_pull_towards_the_action_that_is_least_wrong() -> None:
    """In one state 3, 5 and 6 are met equally often: 7 is one element off each, 0 is two off."""
    actions = np.array([3, 5, 6, 7, 0])
    cases = Cases(np.zeros(5, np.int64), actions, np.array([30, 30, 30, 31, 31]))
    assert CLASSIFIERS["cost_sensitive"].train(ROBOT_DOMAIN, cases)[0] == 7


def test_states_are_one_hot() -> None:
    """A row has one 1 for each variable, and no two states share a row."""
    for domain, variables in ((ROBOT_DOMAIN, 6), (STATION_DOMAIN, 3)):
        assert set(domain.features.sum(axis=1)) == {variables}
        assert len(np.unique(domain.features, axis=0)) == domain.states


def test_wrong_cases_and_names_are_refused() -> None:
    with pytest.raises(InvalidValue, match="no pair to learn from"):
        Cases.from_counts(np.zeros((144, 8), np.int64))
    with pytest.raises(InvalidValue, match="one length"):
        Cases(np.array([1]), np.array([1, 2]), np.array([1]))
    with pytest.raises(InvalidValue, match="never met"):
        Cases(np.array([1]), np.array([1]), np.array([0]))
    with pytest.raises(InvalidValue, match="svm, per_element, majority, cost_sensitive"):
        choose_classifier("forest")
