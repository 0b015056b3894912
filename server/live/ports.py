"""What the live loop needs from the rest of the server, and nothing more.

The live loop knows neither tables nor pages. Whoever stores trials implements `TrialDesk` and
hands it to `server.live.hall.Hall`.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Literal, Protocol

if TYPE_CHECKING:  # the web process loads the compiled world only after it answers
    from server.live.learning.rows import LearningRows
    from study.learning.policy import Policy
    from study.records.events import JournalEvent
    from study.records.journal import JournalChunk
    from study.records.quality import TrialQuality
    from study.warehouse.layout import HallSpec
    from study.warehouse.measures import TrialMeasures

Kind = Literal["practice", "trial", "learning"]
Outcome = Literal["completed", "timed_out", "abandoned"]


@dataclass(frozen=True)
class TrialSetup:
    """Everything that determines a trial besides its inputs, and how to treat its participant.

    `condition` is a name of `study.ar.conditions.CONDITIONS`; `policy` is given for conditions
    that run one. `label` is what the participant may read. `time_scale` 1.0 is real time.
    A trial of a learning run has the condition `learning`, no policy of its own, and its `number`
    in the run, from 0; its display is decided by the run.
    """

    trial_id: str
    kind: Kind
    scale: str
    spec: HallSpec
    seed: int
    condition: str
    policy: Policy | None
    label: str
    mode: str
    time_scale: float = 1.0
    on_disconnect: Literal["pause", "continue"] = "pause"
    abandon_after_s: float = 3600.0
    ribbon_widest_at: Literal["goal", "robot"] = "goal"
    number: int | None = None


@dataclass(frozen=True)
class OpenTrial:
    """A participant's current trial with all that is stored of it, oldest first.

    A journal that is not empty is re-simulated and the trial goes on where it stopped.
    """

    setup: TrialSetup
    journal: tuple[JournalChunk, ...] = ()
    events: tuple[JournalEvent, ...] = ()


@dataclass(frozen=True)
class TrialBatch:
    """What one trial added since the last commit.

    `chunk` is None when no tick passed. `tick` and `phase` say where the trial stands after it.
    A batch may arrive twice (the answer to the first commit was lost): chunks are told apart by
    (trial_id, chunk.first_tick), events by (trial_id, event.number); store each once.
    `learning` is what a trial of a learning run added to that run, stored with the rest or not
    at all.
    """

    trial_id: str
    chunk: JournalChunk | None
    events: tuple[JournalEvent, ...]
    tick: int
    phase: Literal["waiting", "countdown", "running", "paused", "finished"]
    learning: LearningRows | None = None


@dataclass(frozen=True)
class TrialResult:
    """How a trial ended. `state_hash` is the world's state after its last tick (8 bytes)."""

    status: Outcome
    ticks: int
    state_hash: bytes
    ended_at_utc: datetime
    measures: TrialMeasures
    quality: TrialQuality | None = None


class TrialDesk(Protocol):
    """Where trials come from and where they are kept."""

    async def open_trial(self, token: str) -> OpenTrial:
        """The current trial of the participant with this token; its row is made on first call.

        Raises UnknownToken, WrongStep (the current step is no trial) or another StudyError.
        """
        ...

    async def commit(self, batches: Sequence[TrialBatch]) -> Collection[str]:
        """Store the new chunks and events of all rooms in one transaction.

        Returns the ids of trials that are over (their participant withdrew, or was given up):
        nothing is stored of those, and their rooms are to be closed.

        Raises anything when it failed; the batches are then offered again, with later additions
        as further batches.
        """
        ...

    async def finish(self, trial_id: str, result: TrialResult) -> None:
        """Store the result and move the participant on. Called once all batches are committed.

        May be called again for the same trial after a failure; a repeated call changes nothing.
        """
        ...
