"""What a trial adds to its learning run: the rows that travel with the trial's own batches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the web process loads the compiled world only after it answers
    from study.learning.agreement import Setting
    from study.learning.dataset import Pair
    from study.learning.policy import Policy


@dataclass(frozen=True)
class RunVersion:
    """The policy after so many iterations; iteration 0 is the initial policy.

    From iteration 1 on `policy.training["data_sha256"]` is the hash of what it was trained on.
    """

    iteration: int
    policy: Policy


@dataclass(frozen=True)
class LearningRows:
    """What a trial added to its run since the last commit; rides on `TrialBatch.learning`.

    `pairs`: (number in the run from 0, pair). `ratings`: (number in the run from 0, what an expert
    without the lead had set). Like its batch it may arrive twice: pairs are told
    apart by number, versions by iteration, ratings by number; store each once. `iteration`: how
    many iterations are closed. `finished`: the last version has come; the run is over.
    """

    run_id: str
    pairs: tuple[tuple[int, Pair], ...]
    versions: tuple[RunVersion, ...]
    ratings: tuple[tuple[int, Setting], ...]
    iteration: int
    finished: bool
