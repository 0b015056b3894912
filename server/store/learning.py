"""Live learning runs: started once, added to while they go on, ended once."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any, Literal, cast

from sqlalchemy import func, select, update
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.inserting import insert_new
from server.store.participants import hash_token
from server.store.policies import keep_policy
from server.store.tables import (
    LearningPair,
    LearningRating,
    LearningRun,
    LearningVersion,
    StoredPolicy,
)
from study.errors import UnknownRun, UnknownToken
from study.learning.agreement import Setting
from study.learning.dataset import Pair

if TYPE_CHECKING:
    from server.live.learning.rows import LearningRows, RunVersion

FETCH_ROWS = 500
_ID = re.compile(r"[0-9a-f]{32}")
_PAIR_COLUMNS = tuple(getattr(LearningPair, name) for name in Pair._fields)
_SETTING_COLUMNS = tuple(getattr(LearningRating, name) for name in Setting._fields)
RunStatus = Literal["open", "finished", "stopped"]
WorkerKind = Literal["person", "simulated"]


@dataclass(frozen=True)
class NewRun:
    """What is fixed when a run is started; `settings` with the thresholds among them."""

    id: str
    created_by: str
    scale: str
    hall: Mapping[str, Any]
    settings: Mapping[str, Any]
    seed: int
    worker: WorkerKind
    worker_token: str | None


@dataclass(frozen=True)
class RunRecord:
    """A run as pages show it: what it was started with, and how far what is stored has come."""

    id: str
    created_at: datetime
    created_by: str
    scale: str
    hall: Mapping[str, Any]
    settings: Mapping[str, Any]
    seed: int
    worker: WorkerKind
    status: RunStatus
    iteration: int
    pairs: int
    ended_at: datetime | None

    @property
    def short_id(self) -> str:
        """Enough of the id to tell runs apart by eye."""
        return self.id[:6]


async def add_run(session: AsyncSession, run: NewRun, now: datetime) -> None:
    """Store a run that nobody has worked in yet."""
    session.add(
        LearningRun(
            id=run.id,
            created_at=now,
            created_by=run.created_by,
            scale=run.scale,
            hall=dict(run.hall),
            settings=dict(run.settings),
            seed=run.seed,
            worker=run.worker,
            worker_token_hash=hash_token(run.worker_token) if run.worker_token else None,
            status="open",
            iteration=0,
            pairs=0,
        )
    )
    await session.flush()


async def read_run(session: AsyncSession, run_id: str, *, lock: bool = False) -> RunRecord:
    """The run with this id; `lock` holds its row until the transaction ends. Raises UnknownRun."""
    query = select(LearningRun).where(LearningRun.id == run_id)
    row = None
    if _ID.fullmatch(run_id):
        row = await session.scalar(query.with_for_update() if lock else query)
    if row is None:
        raise UnknownRun(run_id)
    return _record(row)


async def find_run(session: AsyncSession, token: str) -> RunRecord:
    """The run whose worker has this token; raises UnknownToken."""
    row = await session.scalar(
        select(LearningRun).where(LearningRun.worker_token_hash == hash_token(token))
    )
    if row is None:
        raise UnknownToken
    return _record(row)


async def list_runs(
    session: AsyncSession, *, offset: int, limit: int
) -> tuple[list[RunRecord], int]:
    """One page of runs, newest first, and how many there are."""
    count = await session.scalar(select(func.count()).select_from(LearningRun))
    rows = await session.scalars(
        select(LearningRun)
        .order_by(LearningRun.created_at.desc(), LearningRun.id)
        .offset(offset)
        .limit(limit)
    )
    return [_record(row) for row in rows], count or 0


async def store_worker_token(session: AsyncSession, run_id: str, token: str) -> None:
    """Let this token lead to the run's worker, and the former one nowhere."""
    await session.execute(
        update(LearningRun)
        .where(LearningRun.id == run_id)
        .values(worker_token_hash=hash_token(token))
    )


async def end_run(session: AsyncSession, run_id: str, status: RunStatus, now: datetime) -> bool:
    """Note that a run is over; False, and nothing changed, if it was over already."""
    ended = await session.scalars(
        update(LearningRun)
        .where(LearningRun.id == run_id, LearningRun.status == "open")
        .values(status=status, ended_at=now)
        .returning(LearningRun.id)
    )
    return ended.first() is not None


async def add_rows(session: AsyncSession, rows: LearningRows, now: datetime) -> None:
    """Store what a trial added to its run; what is stored already is left alone."""
    run = await read_run(session, rows.run_id, lock=True)
    pairs = [{"run_id": run.id, "number": number, **pair._asdict()} for number, pair in rows.pairs]
    await insert_new(session, LearningPair, pairs)
    for version in rows.versions:
        await keep_policy(session, version.policy, "run", now)
    await insert_new(session, LearningVersion, [_version_row(run.id, v) for v in rows.versions])
    ratings = [
        {"run_id": run.id, "number": number, **setting._asdict()}
        for number, setting in rows.ratings
    ]
    await insert_new(session, LearningRating, ratings)
    await session.execute(
        update(LearningRun)
        .where(LearningRun.id == run.id)
        .values(
            iteration=max(run.iteration, rows.iteration),
            pairs=max([run.pairs, *(number + 1 for number, _ in rows.pairs)]),
        )
    )
    if rows.finished:
        await end_run(session, run.id, "finished", now)


async def stream_pairs(session: AsyncSession, run_id: str) -> AsyncIterator[Pair]:
    """The whole dataset of a run, in the order in which it was met, a few at a time."""
    query = (
        select(*_PAIR_COLUMNS).where(LearningPair.run_id == run_id).order_by(LearningPair.number)
    )
    rows = await session.stream(query.execution_options(yield_per=FETCH_ROWS))
    async for row in rows:
        yield Pair(*row)


async def read_ratings(session: AsyncSession, run_id: str) -> tuple[Setting, ...]:
    """What experts without the lead had set in a run, oldest first."""
    rows = await session.execute(
        select(*_SETTING_COLUMNS)
        .where(LearningRating.run_id == run_id)
        .order_by(LearningRating.number)
    )
    return tuple(Setting(*row) for row in rows)


async def read_versions(session: AsyncSession, run_id: str) -> list[tuple[int, str]]:
    """The run's policies: (iteration, text of the policy file), oldest first."""
    rows = await session.execute(
        select(LearningVersion.iteration, StoredPolicy.document)
        .join(StoredPolicy, StoredPolicy.sha256 == LearningVersion.policy_sha256)
        .where(LearningVersion.run_id == run_id)
        .order_by(LearningVersion.iteration)
    )
    return [(iteration, document) for iteration, document in rows]


async def find_version(session: AsyncSession, run_id: str, iteration: int) -> str | None:
    """The text of the policy after so many iterations, if it is stored."""
    return await session.scalar(
        select(StoredPolicy.document)
        .join(LearningVersion, LearningVersion.policy_sha256 == StoredPolicy.sha256)
        .where(LearningVersion.run_id == run_id, LearningVersion.iteration == iteration)
    )


async def find_latest_version(session: AsyncSession, run_id: str) -> tuple[int, str] | None:
    """The newest stored policy of a run: (iteration, text of the policy file)."""
    rows = await session.execute(
        select(LearningVersion.iteration, StoredPolicy.document)
        .join(StoredPolicy, StoredPolicy.sha256 == LearningVersion.policy_sha256)
        .where(LearningVersion.run_id == run_id)
        .order_by(LearningVersion.iteration.desc())
        .limit(1)
    )
    found = rows.first()
    return None if found is None else (found[0], found[1])


def _version_row(run_id: str, version: RunVersion) -> dict[str, Any]:
    return {
        "run_id": run_id,
        "iteration": version.iteration,
        "policy_sha256": version.policy.sha256,
    }


def _record(row: LearningRun) -> RunRecord:
    return RunRecord(
        id=row.id,
        created_at=row.created_at,
        created_by=row.created_by,
        scale=row.scale,
        hall=row.hall,
        settings=row.settings,
        seed=row.seed,
        worker=cast("WorkerKind", row.worker),
        status=cast("RunStatus", row.status),
        iteration=row.iteration,
        pairs=row.pairs,
        ended_at=row.ended_at,
    )
