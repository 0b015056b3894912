"""The dataset D of PolicyUp: every pair of state and action, aggregated over agents and trials."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from study.learning.domains import DOMAINS
from study.learning.training import Counts


class Pair(NamedTuple):
    """One pair, with all that is needed to judge it later.

    tick: of the trial, 1/30 s. domain: 0 robots, 1 stations. agent: number within its kind.
    box: what the expert had set. proposal: what the policy chose for this state. drawn: elements
    that could draw anything at that moment. label: the action that is learned, the box where an
    element was drawn and the proposal elsewhere. edit_ticks: since the expert's last change, -1 if
    there was none. by_expert: 1 if the boxes were displayed in this iteration, 0 the proposal.
    """

    iteration: int
    trial: int
    trial_seed: int
    tick: int
    domain: int
    agent: int
    state: int
    box: int
    proposal: int
    drawn: int
    label: int
    edit_ticks: int
    by_expert: int


class Dataset:
    """All pairs in the order in which they were met; `counts` per domain int64[states, actions]."""

    def __init__(self, pairs: Iterable[Pair] = ()) -> None:
        self.pairs: list[Pair] = []
        self.counts: Counts = tuple(np.zeros((d.states, d.actions), np.int64) for d in DOMAINS)
        self._digest = hashlib.sha256()
        for pair in pairs:
            self.add(pair)

    def __len__(self) -> int:
        return len(self.pairs)

    def __iter__(self) -> Iterator[Pair]:
        return iter(self.pairs)

    def add(self, pair: Pair) -> None:
        """Aggregate one pair (line 15 of the paper's Algorithm 2)."""
        self.pairs.append(pair)
        self.counts[pair.domain][pair.state, pair.label] += 1
        self._digest.update((",".join(map(str, pair)) + "\n").encode())

    def sha256(self) -> str:
        """Hash over all pairs in their order."""
        return self._digest.hexdigest()

    def columns(self) -> npt.NDArray[np.int64]:
        """All pairs as int64[pairs, fields of Pair]."""
        return np.array(self.pairs, np.int64).reshape(-1, len(Pair._fields))
