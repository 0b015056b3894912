"""What live learning runs need from the rest of the server: what is stored of a run, and where.

Whoever stores runs implements `LearningDesk`. What a trial adds to its run travels with the
trial's own batches (`TrialBatch.learning`), so journal and dataset are stored in one transaction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol

from study.errors import StudyError, WrongStep

if TYPE_CHECKING:  # the web process loads the compiled world only after it answers
    from server.live.learning.rows import RunVersion
    from server.live.ports import OpenTrial, TrialSetup
    from study.learning.agreement import Setting
    from study.learning.dataset import Pair
    from study.learning.settings import LearningSettings
    from study.warehouse.halls import HallSpec

WorkerKind = Literal["person", "simulated"]
RunStatus = Literal["open", "finished", "stopped"]


class RunEnded(WrongStep):
    """A socket came to a learning run that is over."""

    def __init__(self) -> None:
        StudyError.__init__(
            self,
            "this learning run has ended",
            next_step="Load the page again to see what came of it.",
        )


@dataclass(frozen=True)
class RunSetup:
    """What determines a run besides its people. `run_id`: 32 hexadecimal digits."""

    run_id: str
    settings: LearningSettings
    scale: str
    spec: HallSpec
    worker: WorkerKind
    created_by: str


@dataclass(frozen=True)
class OpenRun:
    """A run with all that is stored of it, in the order in which it was met.

    `trials`: how many were begun. `trial`: the last of them with its journal, None before the
    first; `trial_ended`: it is over and the next is to begin from where it ended. `start`: what
    `begin_trial` was given for it.
    """

    setup: RunSetup
    status: RunStatus
    versions: tuple[RunVersion, ...]
    pairs: tuple[Pair, ...]
    ratings: tuple[Setting, ...]
    trials: int
    trial: OpenTrial | None
    start: Mapping[str, Any] | None
    trial_ended: bool = False


class LearningDesk(Protocol):
    """Where learning runs come from and where they are kept."""

    async def open_run(self, run_id: str) -> OpenRun:
        """The run with all that is stored of it. Raises UnknownRun."""
        ...

    async def find_worker(self, token: str) -> str:
        """The id of the run whose worker has this token. Raises UnknownToken."""
        ...

    async def begin_trial(
        self, run_id: str, number: int, setup: TrialSetup, start: Mapping[str, Any]
    ) -> None:
        """Make the row of the run's trial `number` (from 0) with the run's state at its start.

        Called again with the same number after a lost answer, it changes nothing. Raises
        WrongMoment if the run is over.
        """
        ...

    async def end_run(self, run_id: str, status: str) -> None:
        """Close the run: `finished` or `stopped`. A run that is closed already stays as it is."""
        ...
