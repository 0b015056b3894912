"""One learning run while it is held in memory: trial after trial, training, experts, storing.

The world is never paused for an expert or a training. Importing this module loads numba; the
server does so after it answers.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass

from server.live.hall import Hall
from server.live.learning import telling, wire
from server.live.learning.experts import Experts, Seat, messages_in
from server.live.learning.opening import NextTrial, Scene, begin_scene, open_room, plan_trial
from server.live.learning.ports import LearningDesk, OpenRun, RunEnded
from server.live.learning.record import RunRecord
from server.live.learning.room import LearningRoom
from server.live.learning.rows import LearningRows
from server.live.learning.trainer import Trainer
from server.live.learning.trainings import Trainings
from server.live.ports import OpenTrial, TrialBatch
from server.live.sink import Sink
from server.live.wire import CloseCode
from study.errors import InvalidValue, StudyError, WrongMoment
from study.learning.session import LearningSession

logger = logging.getLogger(__name__)

WORKER_STAYS_S = 60.0
FIRST_WAIT_S = 1.0
LONGEST_WAIT_S = 30.0


@dataclass(frozen=True)
class RunServices:
    """What a run works with. `forget`: the run is held no longer."""

    desk: LearningDesk
    hall: Hall
    trainer: Trainer
    time_scale: float
    forget: Callable[[LearningRun], None]


class LearningRun:
    """The run's present trial in `room`, its experts, and the trainings under way.

    Made by `resume` (a stored trial goes on) or `begin` (the next trial begins).
    """

    def __init__(self, opened: OpenRun, record: RunRecord, services: RunServices) -> None:
        self.run_id = opened.setup.run_id
        self.record = record
        self.experts = Experts(record)
        self.room: LearningRoom | None = None
        self.is_closed = False
        self._setup = opened.setup
        self._services = services
        self._clock = services.hall.clock
        self._trainings = Trainings(services.trainer, record, self._present_session)
        self._going_on: asyncio.Task[None] | None = None
        self._planned: NextTrial | None = None
        self._watched_s = self._clock.now_s()

    # ---- trials -----------------------------------------------------------------------------

    def resume(self, trial: OpenTrial, scene: Scene) -> None:
        """Go on with a stored trial where it stopped; nobody is there yet."""
        self._enter(trial, scene)

    async def begin(self, former: LearningSession) -> None:
        """Begin the trial after that of `former`. Raises what the desk raises.

        When only trainings are missing, they come first: then the run ends with that trial.
        """
        self._trainings.send(former)
        if former.up.finished:
            await self._trainings.wait()
        if self._planned is None:
            self._planned = plan_trial(self._setup, former, self._services.time_scale)
        planned = self._planned
        await self._services.desk.begin_trial(
            self.run_id, planned.number, planned.setup, planned.start
        )
        scene = begin_scene(self._setup, planned, former)
        self._trainings.send(scene.session)
        scene.session.start(scene.world)
        self._enter(OpenTrial(planned.setup), scene)
        self._planned = None

    async def find_room(self) -> LearningRoom | None:
        """The present trial's room, once it is there; None if the run is held no longer."""
        if self._going_on is not None:
            await asyncio.shield(self._going_on)
        return None if self.is_closed else self.room

    def _enter(self, trial: OpenTrial, scene: Scene) -> None:
        room = self.room = open_room(trial, scene, self._clock)
        self.experts.note_stored(scene.session.panel.taken_by_page().items())
        for page in tuple(scene.session.panel.present):
            room.record(scene.session.leave(page))
        if trial.events:
            last = trial.events[-1].at_utc
            absent_s = (self._clock.utc() - last).total_seconds()
            room.resume(max(0.0, absent_s), was_abandoned=False)
        self.experts.bring_along(room)
        room.attach(self, scene.hands)
        self._services.hall.admit(room)
        if self.is_watched:
            self.experts.show(room)
            room.bring_worker()

    # ---- experts ----------------------------------------------------------------------------

    def join(self, sink: Sink, name: str, client: str) -> Seat:
        """An expert's page comes, and with the first one a simulated worker. Raises StudyError."""
        room = self._present_room()
        seat = Seat(sink, name, client)
        self.experts.join(room, seat)
        room.bring_worker()
        return seat

    def leave(self, seat: Seat) -> None:
        """A page is gone."""
        if self.room is not None:
            self.experts.leave(self.room, seat)
            self._watched_s = self._clock.now_s()

    def edit(self, seat: Seat, message: wire.Edit | wire.Confirm) -> None:
        """A page's gesture, or its word that something is right."""
        self.experts.edit(self._present_room(), seat, message)

    def take_lead(self, seat: Seat) -> None:
        """The lead that nobody connected has goes to this page."""
        room = self._present_room()
        self.experts.change_lead(room, seat, lambda session: session.take_lead(seat.client))

    def hand_over(self, seat: Seat, to: str) -> None:
        """The lead goes to another page."""
        room = self._present_room()
        self.experts.change_lead(room, seat, lambda session: session.hand_over(seat.client, to))

    def _present_room(self) -> LearningRoom:
        if self.room is None or self.is_closed:
            raise RunEnded
        return self.room

    def _present_session(self) -> LearningSession | None:
        return None if self.room is None else self.room.session

    # ---- what the room tells ----------------------------------------------------------------

    @property
    def is_watched(self) -> bool:
        """Whether any expert is there."""
        return len(self.experts) > 0

    def note_period(self, room: LearningRoom) -> None:
        """A simulated worker leaves a minute after the last expert."""
        if not self.is_watched and self._clock.now_s() - self._watched_s > WORKER_STAYS_S:
            room.send_worker_away()

    def note_decision(self, room: LearningRoom) -> None:
        """The run's part of a decision tick: count, train, tell."""
        session = room.session
        self.record.add_pairs(session.take_pairs())
        settings = session.take_settings()
        self.record.add_settings(settings)
        for version in session.up.versions[len(self.record.versions) :]:
            self.record.add_version(self._trainings.take(version.iterations))
        self._trainings.send(session)
        self.experts.tell_state(room)
        if settings:
            self.experts.tell(telling.tell_agreement(self.record))

    def take_rows(self, room: LearningRoom) -> LearningRows | None:
        """What is new for the run's tables."""
        up = room.session.up
        return self.record.take_rows(up.j, finished=up.complete)

    def note_committed(self, batch: TrialBatch) -> None:
        """Tell whose edits are stored, and the curve of what is stored."""
        self.experts.note_stored(messages_in(batch))
        rows = batch.learning
        if rows is not None and rows.iteration > self.record.stored_iterations:
            first, self.record.stored_iterations = self.record.stored_iterations, rows.iteration
            self.experts.tell(telling.tell_curve(self.record, first))

    def note_trial_stored(self, room: LearningRoom) -> None:
        """The next trial begins while anybody is there; a run that is done ends."""
        if not self.is_closed:
            self._going_on = asyncio.create_task(self._go_on(room.session))

    def note_closing(self, code: CloseCode) -> None:
        """The room closes all sockets: the server stops, or the run was stopped."""
        if self.room is None:
            return
        for seat in self.experts:
            self.room.record(self.room.session.leave(seat.client))
        is_over = code == CloseCode.NO_TRIAL
        self.experts.send_away(wire.encode_ended("stopped") if is_over else None, None)
        self.close()

    # ---- going on ---------------------------------------------------------------------------

    async def _go_on(self, session: LearningSession) -> None:
        try:
            if session.up.complete:
                await self._end()
            elif self.is_watched or session.up.finished:
                await self._begin_patiently(session)
            else:
                self.close()
        except Exception:
            logger.exception("a learning run cannot go on; it is opened again from what is stored")
            fault = "this run had a fault; it is opened again"
            self.experts.send_away(None, (CloseCode.TRY_LATER, fault))
            self.close()

    async def _begin_patiently(self, session: LearningSession) -> None:
        """The storage may be away for a while."""
        wait_s = FIRST_WAIT_S
        while not self.is_closed:
            try:
                await self.begin(session)
            except WrongMoment:
                self._part("stopped")
            except InvalidValue:
                raise  # no waiting mends that
            except StudyError as problem:
                logger.warning("the next trial of a run cannot begin yet: %s", problem.sentence)
                await asyncio.sleep(wait_s)
                wait_s = min(LONGEST_WAIT_S, 2 * wait_s)
            else:
                return

    async def _end(self) -> None:
        try:
            await self._services.desk.end_run(self.run_id, "finished")
        except Exception:  # the last batch has closed the run already
            logger.exception("a finished run could not be tidied up")
        self._part("finished")

    def _part(self, status: str) -> None:
        """Tell everybody that the run is over."""
        ended = (CloseCode.NORMAL, "this learning run has ended")
        self.experts.send_away(wire.encode_ended(status), ended)
        self.close()

    def close(self) -> None:
        """The run is held no longer; what is not trained yet is ordered again when it is opened."""
        if not self.is_closed:
            self.is_closed = True
            self._trainings.cancel()
            self._services.forget(self)
