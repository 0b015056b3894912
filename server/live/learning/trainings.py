"""The trainings of one run: ordered, under way, done, and handed to whatever trial goes on then.

Importing this module loads numba; the server does so after it answers.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from server.live.learning.record import RunRecord, as_version
from server.live.learning.rows import RunVersion
from server.live.learning.trainer import Trainer
from study.learning.policy_up import Version
from study.learning.session import LearningSession
from study.learning.training import TrainingOrder


class Trainings:
    """Orders by iteration. `present`: the session that a finished training is offered to."""

    def __init__(
        self,
        trainer: Trainer,
        record: RunRecord,
        present: Callable[[], LearningSession | None],
    ) -> None:
        self._trainer = trainer
        self._record = record
        self._present = present
        self._done: dict[int, RunVersion] = {}
        self._under_way: dict[int, asyncio.Task[None]] = {}

    def send(self, session: LearningSession) -> None:
        """Order what a session is owed, and offer it what is done already."""
        for order in session.owed_orders():
            done = self._done.get(order.iteration)
            if done is not None:
                _offer(session, done)
            elif order.iteration not in self._under_way:
                task = asyncio.create_task(self._train(order))
                self._under_way[order.iteration] = task

    def take(self, iteration: int) -> RunVersion:
        """The version that has been installed."""
        return self._done.pop(iteration)

    async def wait(self) -> None:
        """Return when nothing is under way."""
        await asyncio.gather(*self._under_way.values())

    def cancel(self) -> None:
        """Give up what is under way."""
        for task in self._under_way.values():
            task.cancel()

    async def _train(self, order: TrainingOrder) -> None:
        tables = await self._trainer.train(order)
        version = Version(order.iteration, tables, order.data_sha256)
        self._done[order.iteration] = self._record.describe(version)
        del self._under_way[order.iteration]
        session = self._present()
        if session is not None:
            _offer(session, self._done[order.iteration])


def _offer(session: LearningSession, version: RunVersion) -> None:
    session.offer(as_version(version), version.policy.sha256)
