"""Policies by their hash, and which of them each study runs."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any, Literal, cast

from sqlalchemy import Select, func, or_, select
from sqlalchemy.ext.asyncio import AsyncSession
from sqlalchemy.orm import aliased

from server.store.inserting import insert_new
from server.store.tables import (
    LearningVersion,
    Participant,
    PolicyActivation,
    StoredPolicy,
    Trial,
)
from study.errors import NotFound

if TYPE_CHECKING:
    from study.config import Study
    from study.learning.policy import Policy

_HASH = re.compile(r"[0-9a-f]{64}")
Source = Literal["shipped", "uploaded", "run"]


class UnknownPolicy(NotFound):
    """No policy with this hash is stored."""

    def __init__(self, sha256: str) -> None:
        self.sha256 = sha256
        super().__init__(
            f"there is no policy “{sha256[:64]}” here",
            next_step="Choose one from the list of policies, or upload its file.",
        )


@dataclass(frozen=True)
class PolicyEntry:
    """A stored policy as lists show it.

    `runs` counts the learning runs that made it, `run_id` and `iteration` name one of them;
    `trials` counts participants' trials that ran it; `studies` are those that run it now.
    """

    sha256: str
    name: str
    origin: str
    source: Source
    added_at: datetime
    document: str
    runs: int
    run_id: str | None
    iteration: int | None
    trials: int
    studies: tuple[str, ...]


@dataclass(frozen=True)
class UsedPolicy:
    """A policy that decided in some trials of a study."""

    sha256: str
    name: str
    origin: str


async def keep_policy(session: AsyncSession, policy: Policy, source: Source, now: datetime) -> bool:
    """Store a policy once; True if it is new here."""
    sha256 = policy.sha256
    known = await session.scalar(select(StoredPolicy.sha256).where(StoredPolicy.sha256 == sha256))
    row = {
        "sha256": sha256,
        "document": policy.to_json(),
        "added_at": now,
        "name": policy.name,
        "origin": policy.origin,
        "source": source,
    }
    await insert_new(session, StoredPolicy, [row])
    return known is None


async def read_policies(session: AsyncSession, hashes: Iterable[str]) -> dict[str, str]:
    """Texts of policy files by hash."""
    rows = await session.execute(
        select(StoredPolicy.sha256, StoredPolicy.document).where(
            StoredPolicy.sha256.in_(list(hashes))
        )
    )
    return {sha256: document for sha256, document in rows}  # noqa: C416


async def find_policy(session: AsyncSession, study: Study) -> str | None:
    """The policy that a study's trials run: the one that it names, else the one activated."""
    if study.policy_sha256:
        return (await read_policies(session, [study.policy_sha256]))[study.policy_sha256]
    return await find_active(session, study.study_id)


async def activate(
    session: AsyncSession, study_id: str, sha256: str, user_name: str, now: datetime
) -> None:
    """Let a study's trials run this policy from now on."""
    session.add(
        PolicyActivation(study_id=study_id, policy_sha256=sha256, at=now, user_name=user_name)
    )
    await session.flush()


async def find_active(session: AsyncSession, study_id: str) -> str | None:
    """The text of the policy that a study runs; None where none was ever activated."""
    return await session.scalar(
        select(StoredPolicy.document)
        .join(PolicyActivation, PolicyActivation.policy_sha256 == StoredPolicy.sha256)
        .where(PolicyActivation.study_id == study_id)
        .order_by(PolicyActivation.id.desc())
        .limit(1)
    )


async def list_used(session: AsyncSession, study_id: str, mode: str | None) -> list[UsedPolicy]:
    """The policies that trials of a study ran, the practice left out."""
    used = (
        select(Trial.policy_sha256)
        .join(Participant, Participant.id == Trial.participant_id)
        .where(Participant.study_id == study_id, Trial.kind == "trial")
    )
    if mode is not None:
        used = used.where(Participant.mode == mode)
    rows = await session.execute(
        select(StoredPolicy.sha256, StoredPolicy.name, StoredPolicy.origin)
        .where(StoredPolicy.sha256.in_(used))
        .order_by(StoredPolicy.sha256)
    )
    return [UsedPolicy(*row) for row in rows]


async def read_entry(session: AsyncSession, sha256: str) -> PolicyEntry:
    """One stored policy; raises `UnknownPolicy`."""
    rows = []
    if _HASH.fullmatch(sha256):
        query = select(StoredPolicy).where(StoredPolicy.sha256 == sha256)
        rows = list(await session.scalars(query))
    if not rows:
        raise UnknownPolicy(sha256)
    (entry,) = await _describe(session, rows)
    return entry


async def list_policies(
    session: AsyncSession, *, offset: int, limit: int
) -> tuple[list[PolicyEntry], int]:
    """One page of policies, newest first, and how many there are.

    Of a learning run only the newest version is listed, and those that are or were in use.
    """
    of_run = aliased(LearningVersion)
    newest = select(LearningVersion.policy_sha256).where(
        LearningVersion.policy_sha256 == StoredPolicy.sha256,
        LearningVersion.iteration
        == select(func.max(of_run.iteration))
        .where(of_run.run_id == LearningVersion.run_id)
        .scalar_subquery(),
    )
    used = select(Trial.id).where(Trial.policy_sha256 == StoredPolicy.sha256)
    active = select(PolicyActivation.id).where(
        PolicyActivation.policy_sha256 == StoredPolicy.sha256
    )
    query = select(StoredPolicy).where(
        or_(StoredPolicy.source != "run", newest.exists(), used.exists(), active.exists())
    )
    ordered = query.order_by(StoredPolicy.added_at.desc(), StoredPolicy.sha256)
    return await _page(session, ordered, offset, limit)


async def list_run_policies(
    session: AsyncSession, run_id: str, *, offset: int, limit: int
) -> tuple[list[PolicyEntry], int]:
    """One page of a learning run's versions, newest first, and how many there are."""
    query = (
        select(StoredPolicy)
        .join(LearningVersion, LearningVersion.policy_sha256 == StoredPolicy.sha256)
        .where(LearningVersion.run_id == run_id)
        .order_by(LearningVersion.iteration.desc())
    )
    return await _page(session, query, offset, limit)


async def _page(
    session: AsyncSession, query: Select[Any], offset: int, limit: int
) -> tuple[list[PolicyEntry], int]:
    total = await session.scalar(select(func.count()).select_from(query.subquery()))
    rows = list(await session.scalars(query.offset(offset).limit(limit)))
    return await _describe(session, rows), total or 0


async def _describe(session: AsyncSession, rows: list[StoredPolicy]) -> list[PolicyEntry]:
    """Add to each policy where it was learned and where it is used."""
    hashes = [row.sha256 for row in rows]
    runs = await session.execute(
        select(
            LearningVersion.policy_sha256,
            func.count(LearningVersion.run_id.distinct()),
            func.max(LearningVersion.run_id),
            func.max(LearningVersion.iteration),
        )
        .where(LearningVersion.policy_sha256.in_(hashes))
        .group_by(LearningVersion.policy_sha256)
    )
    learned = {sha256: (count, run, iteration) for sha256, count, run, iteration in runs}
    used = await session.execute(
        select(Trial.policy_sha256, func.count())
        .where(Trial.policy_sha256.in_(hashes), Trial.participant_id.is_not(None))
        .group_by(Trial.policy_sha256)
    )
    trials: dict[str | None, int] = {sha256: count for sha256, count in used}  # noqa: C416
    newest = select(func.max(PolicyActivation.id)).group_by(PolicyActivation.study_id)
    active = await session.execute(
        select(PolicyActivation.policy_sha256, PolicyActivation.study_id)
        .where(PolicyActivation.id.in_(newest), PolicyActivation.policy_sha256.in_(hashes))
        .order_by(PolicyActivation.study_id)
    )
    studies: dict[str, list[str]] = {}
    for sha256, study_id in active:
        studies.setdefault(sha256, []).append(study_id)
    entries = []
    for row in rows:
        count, run_id, iteration = learned.get(row.sha256, (0, None, None))
        entries.append(
            PolicyEntry(
                sha256=row.sha256,
                name=row.name,
                origin=row.origin,
                source=cast("Source", row.source),
                added_at=row.added_at,
                document=row.document,
                runs=count,
                run_id=run_id,
                iteration=iteration,
                trials=trials.get(row.sha256, 0),
                studies=tuple(studies.get(row.sha256, ())),
            )
        )
    return entries
