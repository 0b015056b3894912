"""The examination of a classifier: whoever writes one runs it. It fails, it never warns."""

from __future__ import annotations

import numpy as np

from study.learning.classifiers import Cases, Classifier, Table
from study.learning.domains import DOMAINS, Domain

ROUNDS = 5


class ClassifierFailed(AssertionError):
    """The classifier broke its promise; the text says which and where."""


def examine_classifier(classifier: Classifier, seed: int = 0) -> None:
    """Train on constant, single, scarce and noisy cases of both kinds of agents."""
    draws = np.random.default_rng(seed)
    for domain in DOMAINS:
        for action in range(domain.actions):
            one = Cases(np.array([domain.states // 2]), np.array([action]), np.array([3]))
            table = _train(classifier, domain, one, f"{domain.name}, a single pair")
            _demand(bool((table == action).all()), "one class must give a constant table", domain)
        for _ in range(ROUNDS):
            counts = np.zeros((domain.states, domain.actions), np.int64)
            rows = int(draws.integers(2, 60))
            states = draws.integers(0, domain.states, rows)
            actions = draws.integers(0, domain.actions, rows)
            np.add.at(counts, (states, actions), draws.integers(1, 9, rows))
            before = counts.copy()
            cases = Cases.from_counts(counts)
            table = _train(classifier, domain, cases, domain.name)
            again = _train(classifier, domain, cases, domain.name)
            _demand(bool((table == again).all()), "trained twice, it gave two tables", domain)
            same = bool((counts == before).all()) and len(cases.states) == (before > 0).sum()
            _demand(same, "it changed the cases it was given", domain)


def _train(classifier: Classifier, domain: Domain, cases: Cases, where: str) -> Table:
    table = classifier.train(domain, cases)
    if table.shape != (domain.states,) or table.dtype != np.int64:
        raise ClassifierFailed(f"{where}: a table {table.shape} of {table.dtype}")
    if table.min() < 0 or table.max() >= domain.actions:
        raise ClassifierFailed(f"{where}: an action off the scale")
    return table


def _demand(holds: bool, complaint: str, domain: Domain) -> None:
    if not holds:
        raise ClassifierFailed(f"{domain.name}: {complaint}")
