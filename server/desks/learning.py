"""Where learning runs come from and are kept; each question of pages or live loop is one
transaction.
"""

from __future__ import annotations

import asyncio
import csv
import io
import secrets
import uuid
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass
from typing import Any

from server.desks.learning_records import (
    STEP,
    read_settings,
    read_versions,
    record_trial,
    run_setup,
)
from server.desks.trials import Clock, read_setup, utc_now
from server.live.learning.ports import OpenRun
from server.live.ports import OpenTrial, TrialSetup
from server.store import learning as runs
from server.store.audit import add_audit
from server.store.engine import Database
from server.store.journals import read_journal
from server.store.learning import NewRun, RunRecord, RunStatus, WorkerKind
from server.store.trials import abandon_run_trials, add_trial, list_run_trials
from server.tokens import looks_like_token
from study.errors import NotFound, UnknownToken, WrongMoment
from study.learning.dataset_rows import DATASET_FIELDS, dataset_row
from study.learning.policy import initial_policy
from study.learning.settings import LearningSettings
from study.warehouse.halls import PRESETS

LINES_PER_PIECE = 500


class RunOver(WrongMoment):
    """Something was asked of a learning run that has ended."""

    def __init__(self, run_id: str) -> None:
        self.run_id = run_id
        super().__init__(
            f"the learning run {run_id[:6]} has ended",
            next_step="Its data and policies are kept; start a new run to go on learning.",
        )


class NoWorkerLink(WrongMoment):
    """A link for a worker was asked of a run whose worker is simulated."""

    def __init__(self) -> None:
        super().__init__(
            "the worker of this run is simulated, so nobody can join it",
            next_step="Start a run with a person as its worker.",
        )


class UnknownVersion(NotFound):
    """The run has no policy after so many iterations yet."""

    def __init__(self, iteration: int) -> None:
        self.iteration = iteration
        super().__init__(
            f"no policy after {iteration} iterations is stored",
            next_step="The page of the run says how many iterations there are.",
        )


@dataclass(frozen=True)
class RunRequest:
    """What somebody asks for who starts a run."""

    scale: str
    settings: LearningSettings
    worker: WorkerKind


@dataclass(frozen=True)
class StoredLearningDesk:
    """Implements `server.live.learning.ports.LearningDesk` on the database."""

    database: Database
    clock: Clock = utc_now

    async def create_run(self, request: RunRequest, user_name: str) -> tuple[str, str | None]:
        """Start a run; returns its id and, if a person is to work in it, the worker's token.

        The token is stored hashed: nobody can read it again.
        """
        run_id = uuid.uuid4().hex
        token = _make_token() if request.worker == "person" else None
        settings, now = request.settings, self.clock()
        new = NewRun(
            id=run_id,
            created_by=user_name,
            scale=request.scale,
            hall=PRESETS[request.scale].to_json(),
            settings=settings.to_json() | {"thresholds": settings.thresholds.to_json()},
            seed=settings.seed,
            worker=request.worker,
            worker_token=token,
        )
        async with self.database.writing() as session:
            await runs.add_run(session, new, now)
            detail = f"{run_id}, {request.scale}, worker {request.worker}"
            await add_audit(session, user_name, "learning run started", detail, now)
        return run_id, token

    async def renew_worker_link(self, run_id: str, user_name: str) -> str:
        """A new token for the run's worker; the former one leads nowhere from now on.

        Raises UnknownRun, `RunOver`, `NoWorkerLink`.
        """
        token, now = _make_token(), self.clock()
        async with self.database.writing() as session:
            run = await runs.read_run(session, run_id, lock=True)
            if run.worker != "person":
                raise NoWorkerLink
            if run.status != "open":
                raise RunOver(run_id)
            await runs.store_worker_token(session, run_id, token)
            await add_audit(session, user_name, "worker link made", run_id, now)
        return token

    async def stop_run(self, run_id: str, user_name: str) -> None:
        """End a run before its time; what is stored of it stays. Once only; raises UnknownRun."""
        now = self.clock()
        async with self.database.writing() as session:
            await runs.read_run(session, run_id, lock=True)
            if await runs.end_run(session, run_id, "stopped", now):
                await abandon_run_trials(session, run_id, now)
                await add_audit(session, user_name, "learning run stopped", run_id, now)

    async def list_runs(self, *, offset: int, limit: int) -> tuple[list[RunRecord], int]:
        """One page of runs, newest first, and how many there are."""
        async with self.database.reading() as session:
            return await runs.list_runs(session, offset=offset, limit=limit)

    async def read_run_summary(self, run_id: str) -> RunRecord:
        """The run as its page shows it; raises UnknownRun."""
        async with self.database.reading() as session:
            return await runs.read_run(session, run_id)

    async def read_version(self, run_id: str, iteration: int) -> str:
        """The file of the policy after so many iterations; raises UnknownRun, `UnknownVersion`.

        Iteration 0 is the initial policy, also before the run was opened for the first time.
        """
        async with self.database.reading() as session:
            run = await runs.read_run(session, run_id)
            document = await runs.find_version(session, run_id, iteration)
        if document is None and iteration == 0:
            return initial_policy(read_settings(run).thresholds).to_json()
        if document is None:
            raise UnknownVersion(iteration)
        return document

    async def read_latest_version(self, run_id: str) -> tuple[int, str]:
        """The run's newest stored policy: its iteration and its file; raises UnknownRun.

        The last iterations may be closed while their policies are still in training; those of a
        run that was stopped then never come.
        """
        async with self.database.reading() as session:
            run = await runs.read_run(session, run_id)
            found = await runs.find_latest_version(session, run_id)
        return found or (0, initial_policy(read_settings(run).thresholds).to_json())

    async def stream_dataset(self, run_id: str) -> AsyncIterator[str]:
        """The run's dataset as CSV, in pieces, with the columns that `varil learn` writes."""
        out = io.StringIO()
        writer = csv.writer(out)
        writer.writerow(DATASET_FIELDS)
        async with self.database.reading() as session:
            settings = read_settings(await runs.read_run(session, run_id))
            waiting = 0
            async for pair in runs.stream_pairs(session, run_id):
                writer.writerow(dataset_row(pair, settings, "people"))
                waiting += 1
                if waiting == LINES_PER_PIECE:
                    yield out.getvalue()
                    out.seek(0)
                    out.truncate()
                    waiting = 0
        yield out.getvalue()

    async def open_run(self, run_id: str) -> OpenRun:
        """The run with all that is stored of it; raises UnknownRun."""
        async with self.database.reading() as session:
            run = await runs.read_run(session, run_id)
            trials = await list_run_trials(session, run_id)
            documents = await runs.read_versions(session, run_id)
            pairs = [pair async for pair in runs.stream_pairs(session, run_id)]
            ratings = await runs.read_ratings(session, run_id)
            last = trials[-1] if trials else None
            trial, start = None, None
            if last is not None:
                journal, events = await read_journal(session, last.id)
                setup = read_setup(last, last.config["mode"], None)
                trial, start = OpenTrial(setup, journal, events), last.config[STEP]["start"]
        return OpenRun(
            setup=run_setup(run),
            status=run.status,
            versions=await asyncio.to_thread(read_versions, documents),
            pairs=tuple(pairs),
            ratings=ratings,
            trials=len(trials),
            trial=trial,
            start=start,
            trial_ended=last is not None and last.status != "open",
        )

    async def find_worker(self, token: str) -> str:
        """The id of the run whose worker has this token; raises UnknownToken."""
        return (await self.find_worker_run(token)).id

    async def find_worker_run(self, token: str) -> RunRecord:
        """The run whose worker has this token; raises UnknownToken."""
        if not looks_like_token(token):
            raise UnknownToken
        async with self.database.reading() as session:
            return await runs.find_run(session, token)

    async def begin_trial(
        self, run_id: str, number: int, setup: TrialSetup, start: Mapping[str, Any]
    ) -> None:
        """Store the run's trial `number` (from 0) with the run's state at its start.

        Called again with the same trial it changes nothing; an earlier trial that never ended
        counts as abandoned. Raises UnknownRun, `RunOver`.
        """
        now = self.clock()
        async with self.database.writing() as session:
            run = await runs.read_run(session, run_id, lock=True)
            trials = await list_run_trials(session, run_id)
            if any(trial.id == setup.trial_id for trial in trials):
                return
            if run.status != "open":
                raise RunOver(run_id)
            if number != len(trials):
                raise RuntimeError(f"run {run_id}: trial {number} after {len(trials)} trials")
            await abandon_run_trials(session, run_id, now)
            await add_trial(session, record_trial(run, number, setup, start), now)

    async def end_run(self, run_id: str, status: str) -> None:
        """Close the run: `finished` or `stopped`. One that is closed stays as it is."""
        if status not in ("finished", "stopped"):
            raise ValueError(f"a run cannot end as {status!r}")
        now = self.clock()
        ended: RunStatus = "finished" if status == "finished" else "stopped"
        async with self.database.writing() as session:
            await runs.read_run(session, run_id, lock=True)
            await runs.end_run(session, run_id, ended, now)
            await abandon_run_trials(session, run_id, now)


def _make_token() -> str:
    """192 random bits, url-safe; as long as participants' tokens."""
    return secrets.token_urlsafe(24)
