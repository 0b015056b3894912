"""A trial of a learning run: an ordinary room whose display is decided by the run.

Importing this module loads numba; the server does so after it answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

from server.live.chronicle import Chronicle
from server.live.clock import Clock
from server.live.inbox import Inbox
from server.live.ports import TrialBatch, TrialSetup
from server.live.room import Room
from server.live.wire import CloseCode
from study.ar.display import DECISION_EVERY_TICKS
from study.learning.session import Entry, LearningSession

if TYPE_CHECKING:
    from server.live.learning.rows import LearningRows
    from server.live.learning.simulated_worker import SimulatedWorker
    from study.warehouse.world import World

CHECK_EVERY_S = 5.0


class TrialOwner(Protocol):
    """What a room tells the run that it belongs to."""

    @property
    def is_watched(self) -> bool:
        """Whether any expert is there."""
        ...

    def note_period(self, room: LearningRoom) -> None:
        """A thirtieth of a second has passed."""
        ...

    def note_decision(self, room: LearningRoom) -> None:
        """A decision tick is done."""
        ...

    def take_rows(self, room: LearningRoom) -> LearningRows | None:
        """What is new for the run's own tables."""
        ...

    def note_committed(self, batch: TrialBatch) -> None:
        """This is stored for good."""
        ...

    def note_trial_stored(self, room: LearningRoom) -> None:
        """The trial is over and its result is stored."""
        ...

    def note_closing(self, code: CloseCode) -> None:
        """The room is about to close every socket."""
        ...


class LearningRoom(Room):
    """A room that hands its run what happens, and stores what the run adds.

    `hands` is the simulated worker, None where a person works. The trial ends with the run.
    """

    def __init__(
        self,
        setup: TrialSetup,
        world: World,
        session: LearningSession,
        chronicle: Chronicle,
        inbox: Inbox,
        clock: Clock,
    ) -> None:
        super().__init__(setup, world, session, chronicle, inbox, clock)
        self.session = session
        self._owner: TrialOwner | None = None
        self._hands: SimulatedWorker | None = None
        self._batched_s = clock.now_s()

    def attach(self, owner: TrialOwner, hands: SimulatedWorker | None) -> None:
        """From now on the trial belongs to this run."""
        self._owner, self._hands = owner, hands
        self._settle_tick()

    def record(self, entries: Sequence[Entry]) -> None:
        """Write down what experts did, or the run, at the present tick."""
        for kind, data in entries:
            self._chronicle.note(kind, data)

    # ---- the simulated worker ---------------------------------------------------------------

    def bring_worker(self) -> None:
        """Let the simulated worker, if there is one, take part."""
        if self._hands is not None and not self.is_joined and self.result is None:
            self.join(self._hands)
            self.take_ready()

    def send_worker_away(self) -> None:
        """The simulated worker leaves, and the world pauses."""
        if self._hands is not None and self.is_joined:
            self.leave(self._hands, CloseCode.NORMAL)

    # ---- time -------------------------------------------------------------------------------

    def advance(self) -> None:
        """As any room; a simulated worker is always ready to go on."""
        if self._owner is not None:
            self._owner.note_period(self)
        if self._hands is not None and self.is_joined and self.phase in ("waiting", "paused"):
            self.take_ready()
        super().advance()

    def step(self) -> None:
        """One tick; the worker's frame comes before it, the run's part after it."""
        if self._hands is not None and self.is_joined:
            self.take_input(self._hands.next_input(self.session.display))
        super().step()
        if self.world.tick % DECISION_EVERY_TICKS == 0:
            self._settle_tick()

    def _settle_tick(self) -> None:
        self.record(self.session.take_entries())
        if self._owner is not None:
            self._owner.note_decision(self)
        if self.session.up.complete and self.result is None:
            self._finish("completed", "abandoned")

    # ---- storing ----------------------------------------------------------------------------

    def take_batch(self) -> TrialBatch | None:
        """What happened since the last call. While experts watch, now and then an empty batch:
        the answer tells whether the run was stopped elsewhere.
        """
        batch = super().take_batch()
        now_s = self._clock.now_s()
        if self._owner is None:
            return batch
        rows = self._owner.take_rows(self)
        is_asking = self._owner.is_watched and now_s - self._batched_s > CHECK_EVERY_S
        if batch is None and (rows is not None or is_asking):
            batch = TrialBatch(self.setup.trial_id, None, (), self.world.tick, self.phase)
        if batch is None:
            return None
        self._batched_s = now_s
        return replace(batch, learning=rows)

    def note_committed(self, batch: TrialBatch) -> None:
        """Experts hear what of theirs is stored."""
        if self._owner is not None:
            self._owner.note_committed(batch)

    def finish_stored(self) -> None:
        """The worker may go on, and so may the run."""
        super().finish_stored()
        if self._owner is not None:
            self._owner.note_trial_stored(self)

    def shut_down(self, code: CloseCode, reason: str) -> None:
        """Everybody leaves; the run is opened again when somebody comes."""
        if self._owner is not None:
            self._owner.note_closing(code)
        super().shut_down(code, reason)
