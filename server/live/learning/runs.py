"""All learning runs that are held in memory; each is opened once, however many ask for it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from server.live.hall import Hall
from server.live.learning.ports import LearningDesk, RunEnded
from server.live.learning.trainer import Trainer

if TYPE_CHECKING:  # loads numba, so not before a run is opened
    from server.live.learning.room import LearningRoom
    from server.live.learning.run import LearningRun


class LearningRuns:
    """Runs by id. Their trials are driven and stored by the hall, like all trials.

    `time_scale` 1.0 is real time. Call `stop` after the hall has stopped.
    """

    def __init__(
        self, desk: LearningDesk, hall: Hall, trainer: Trainer, time_scale: float = 1.0
    ) -> None:
        self.held: dict[str, LearningRun] = {}
        self._desk = desk
        self._hall = hall
        self._trainer = trainer
        self._time_scale = time_scale
        self._opening: dict[str, asyncio.Task[LearningRun]] = {}

    async def enter(self, token: str) -> LearningRoom:
        """The room of a run's present trial, for its worker. Raises UnknownToken, RunEnded."""
        run_id = await self._desk.find_worker(token)
        while True:
            room = await (await self.open(run_id)).find_room()
            if room is not None:
                return room

    async def open(self, run_id: str) -> LearningRun:
        """The run, opened if need be. Raises UnknownRun, RunEnded, or what opening it raises."""
        await self._hall.settle()
        held = self.held.get(run_id)
        if held is not None:
            return held
        task = self._opening.get(run_id)
        if task is None:
            task = self._opening[run_id] = asyncio.create_task(self._open(run_id))
        return await asyncio.shield(task)

    async def describe_ended(self, run_id: str, you: tuple[str, str]) -> list[str]:
        """What a page is told of a run that is over. `you`: name, page. Raises UnknownRun."""
        from server.live.learning.record import RunRecord
        from server.live.learning.telling import tell_ended

        opened = await self._desk.open_run(run_id)
        record = await RunRecord.gather(opened)
        if opened.status == "finished":
            record.stored_iterations = opened.setup.settings.iterations
        return tell_ended(record, you, opened.status)

    async def stop(self) -> None:
        """Give up what is being opened, and the trainings."""
        for task in self._opening.values():
            task.cancel()
        for run in tuple(self.held.values()):
            run.close()
        await self._trainer.stop()

    async def _open(self, run_id: str) -> LearningRun:
        from server.live.learning.opening import first_session, run_again
        from server.live.learning.record import RunRecord
        from server.live.learning.run import LearningRun, RunServices

        try:
            opened = await self._desk.open_run(run_id)
            if opened.status != "open":
                raise RunEnded
            self._trainer.warm_up()
            services = RunServices(
                self._desk, self._hall, self._trainer, self._time_scale, self._forget
            )
            record = await RunRecord.gather(opened)
            run = LearningRun(opened, record, services)
            if opened.trial is None:
                await run.begin(first_session(opened.setup))
            else:
                scene = await run_again(opened, opened.trial, record)
                record.catch_up(scene.session)
                if opened.trial_ended:
                    await run.begin(scene.session)
                else:
                    run.resume(opened.trial, scene)
            self.held[run_id] = run
            return run
        finally:
            del self._opening[run_id]

    def _forget(self, run: LearningRun) -> None:
        if self.held.get(run.run_id) is run:
            del self.held[run.run_id]
