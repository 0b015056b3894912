"""The kinds of agents as a classifier meets them: states as one-hot rows, actions as classes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from study.ar.elements import ROBOT_ACTIONS, STATION_ACTIONS
from study.ar.state_names import ROBOT_VARIABLES, STATION_VARIABLES


@dataclass(frozen=True, eq=False)
class Domain:
    """One kind of agent. `features`: float64[states, values of all variables], read-only.

    `actions`: number of classes; `elements`: bits of an action.
    """

    name: str
    features: npt.NDArray[np.float64]
    actions: int
    elements: int

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.features)


def _one_hot(variables: Mapping[str, Sequence[str]]) -> npt.NDArray[np.float64]:
    """Return a row per state in the tables' order, a column per value of each variable."""
    rows = [
        np.concatenate(
            [np.eye(len(values))[at] for values, at in zip(variables.values(), chosen, strict=True)]
        )
        for chosen in product(*(range(len(values)) for values in variables.values()))
    ]
    features = np.array(rows)
    features.setflags(write=False)
    return features


ROBOT_DOMAIN = Domain("robot", _one_hot(ROBOT_VARIABLES), ROBOT_ACTIONS, 3)
STATION_DOMAIN = Domain("station", _one_hot(STATION_VARIABLES), STATION_ACTIONS, 1)
DOMAINS = (ROBOT_DOMAIN, STATION_DOMAIN)


def count_elements(masks: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """How many of the three elements each mask has."""
    counts: npt.NDArray[np.int64] = np.bitwise_count(masks & 7).astype(np.int64)
    return counts
