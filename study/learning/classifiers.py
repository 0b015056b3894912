"""Classifiers that turn counted pairs of state and action into a lookup table.

All stand behind one protocol; whoever writes another runs `study.learning.examination` on it.
Training sees each different pair once, weighted by how often it was met: with a kernel machine
that is the same problem as the one over all rows, a hundred times smaller. Neither the kernel nor
the parameters are published: RBF, C = 1, one against one is our choice, made by libsvm through
scikit-learn, which is loaded at the first training only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from types import MappingProxyType
from typing import Any, Protocol, cast

import numpy as np
import numpy.typing as npt

from study.errors import InvalidValue
from study.learning.domains import Domain, count_elements

Table = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Cases:
    """Different pairs and how often each was met: int64[n] each, n from 1, counts from 1."""

    states: npt.NDArray[np.int64]
    actions: npt.NDArray[np.int64]
    counts: npt.NDArray[np.int64]

    def __post_init__(self) -> None:
        sizes = {len(self.states), len(self.actions), len(self.counts)}
        if len(sizes) != 1:
            raise InvalidValue(f"cases need columns of one length, not {sorted(sizes)}")
        if not len(self.states):
            raise InvalidValue(
                "there is no pair to learn from",
                next_step="Train once the dataset holds at least one pair of this kind of agent.",
            )
        if int(self.counts.min()) < 1:
            raise InvalidValue("a case that was never met has no place among the cases")

    @classmethod
    def from_counts(cls, counts: npt.NDArray[np.int64]) -> Cases:
        """Cases of a table int64[states, actions] of counts, in order of state and action."""
        states, actions = np.nonzero(counts)
        return cls(states, actions, counts[states, actions])


class Classifier(Protocol):
    """Learns one action per state."""

    def train(self, domain: Domain, cases: Cases) -> Table:
        """Return the action of every state, int64[states]. Same cases, same table.

        With a single class among the cases the table is constant.
        """
        ...


class JointSvm:
    """One machine over joint actions: one against one, that is all-pairs with 0/1 costs."""

    def train(self, domain: Domain, cases: Cases) -> Table:
        """Fit the joint actions."""
        return predict_all(domain, cases.states, cases.actions, cases.counts)


class PerElement:
    """One machine for each element on its own; their answers together are the action."""

    def train(self, domain: Domain, cases: Cases) -> Table:
        """Fit each bit."""
        table = np.zeros(domain.states, np.int64)
        for bit in range(domain.elements):
            wanted = cases.actions >> bit & 1
            table |= predict_all(domain, cases.states, wanted, cases.counts) << bit
        return table


class Majority:
    """The action met most often, whatever the state: a control. Ties: the lowest number."""

    def train(self, domain: Domain, cases: Cases) -> Table:
        """Count."""
        totals = np.bincount(cases.actions, weights=cases.counts, minlength=domain.actions)
        return np.full(domain.states, int(np.argmax(totals)), np.int64)


class CostSensitive:
    """All-pairs weighted by cost, the cost of a wrong action being the elements it has wrong.

    For each two of the actions met, a machine over *all* cases decides which of the two costs
    less; a case weighs as much as the two differ in cost. The action with most votes wins, ties go
    to the lowest number.
    """

    def train(self, domain: Domain, cases: Cases) -> Table:
        """Fit a machine for each two actions and count their votes."""
        met = np.unique(cases.actions)
        votes = np.zeros((domain.states, domain.actions), np.int64)
        votes[:, met[0]] = 1 if len(met) == 1 else 0
        for first, second in combinations(met.tolist(), 2):
            gain = _hamming(cases.actions, second) - _hamming(cases.actions, first)
            matters = gain != 0
            picks = np.where(gain > 0, first, second)[matters]
            weights = (np.abs(gain) * cases.counts)[matters]
            chosen = predict_all(domain, cases.states[matters], picks, weights)
            votes[np.arange(domain.states), chosen] += 1
        winners: Table = np.argmax(votes, axis=1).astype(np.int64)
        return winners


def predict_all(
    domain: Domain,
    states: npt.NDArray[np.int64],
    targets: npt.NDArray[np.int64],
    weights: npt.NDArray[np.int64],
) -> Table:
    """Fit a machine to weighted cases and ask it for every state of the domain."""
    met = np.unique(targets)
    if len(met) == 1:
        return np.full(domain.states, met[0], np.int64)
    machine = new_machine()
    machine.fit(domain.features[states], targets, sample_weight=weights.astype(np.float64))
    return cast(Table, machine.predict(domain.features))


def new_machine() -> Any:
    """An untrained support vector machine with the settings that all of them share."""
    from sklearn.svm import SVC  # two seconds of import that the web process must not pay

    return SVC(kernel="rbf", C=1.0, gamma="scale", decision_function_shape="ovo")


def _hamming(actions: npt.NDArray[np.int64], other: int) -> npt.NDArray[np.int64]:
    return count_elements(actions ^ other)


CLASSIFIERS: Mapping[str, Classifier] = MappingProxyType(
    {
        "svm": JointSvm(),
        "per_element": PerElement(),
        "majority": Majority(),
        "cost_sensitive": CostSensitive(),
    }
)


def choose_classifier(name: str) -> Classifier:
    """Return the classifier of this name. Errors: InvalidValue naming those that exist."""
    if name not in CLASSIFIERS:
        raise InvalidValue(
            f"there is no classifier “{name[:40]}”",
            next_step=f"Use one of: {', '.join(CLASSIFIERS)}.",
        )
    return CLASSIFIERS[name]
