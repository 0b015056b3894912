"""The dataset as a table, whoever writes it: the names of its columns, and a row per pair."""

from __future__ import annotations

from study.ar.state_names import ROBOT_STATES, STATION_STATES
from study.learning.dataset import Pair
from study.learning.domains import DOMAINS
from study.learning.settings import LearningSettings

DATASET_FIELDS = (
    "iteration", "trial", "trial_seed", "tick", "agent_kind", "agent", "state", "box", "proposal",
    "drawn", "label", "edit_age_s", "displayed", "box_mode", "label_source", "origin",
)  # fmt: skip
_STATES = (ROBOT_STATES, STATION_STATES)
_TICK_HZ = 30


def dataset_row(pair: Pair, settings: LearningSettings, origin: str) -> tuple[object, ...]:
    """Return a pair's cells.

    Masks are numbers: 1 live location, 2 transparent avatar, 4 trajectory; of a station 1 balloon.
    `origin` says who set the boxes: `people` or `simulated`.
    """
    return (
        pair.iteration,
        pair.trial,
        pair.trial_seed,
        pair.tick,
        DOMAINS[pair.domain].name,
        pair.agent,
        _STATES[pair.domain][pair.state],
        pair.box,
        pair.proposal,
        pair.drawn,
        pair.label,
        "" if pair.edit_ticks < 0 else round(pair.edit_ticks / _TICK_HZ, 3),
        "expert" if pair.by_expert else "policy",
        settings.box_mode,
        settings.label_source,
        origin,
    )
