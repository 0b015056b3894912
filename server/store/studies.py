"""Versions of studies: frozen once somebody has joined, a draft before."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import delete, func, select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.inserting import insert_new
from server.store.tables import Participant, StudyVersion
from study.config import Study
from study.files.earlier import read_stored


@dataclass(frozen=True)
class VersionEntry:
    """A stored version; `number` counts a study's versions from 1, `joined` its participants."""

    number: int
    config_hash: str
    added_at: datetime
    joined: int


async def keep_version(session: AsyncSession, study: Study, now: datetime) -> int:
    """Id of this version of the study; a version met for the first time is stored."""
    here = select(StudyVersion.id).where(StudyVersion.config_hash == study.config_hash)
    known = await session.scalar(here)
    if known is not None:
        return known
    row = {
        "study_id": study.study_id,
        "config_hash": study.config_hash,
        "config_json": study.canonical_json,
        "added_at": now,
    }
    await insert_new(session, StudyVersion, [row])
    return (await session.scalars(here)).one()


async def drop_drafts(session: AsyncSession, study: Study) -> None:
    """Forget versions of a study that nobody joined, but for the one given."""
    joined = select(Participant.id).where(Participant.study_version_id == StudyVersion.id)
    await session.execute(
        delete(StudyVersion).where(
            StudyVersion.study_id == study.study_id,
            StudyVersion.config_hash != study.config_hash,
            ~joined.exists(),
        )
    )


async def list_entries(session: AsyncSession, study_id: str) -> list[VersionEntry]:
    """The versions of a study with how many joined each, oldest first."""
    joined = select(func.count()).where(Participant.study_version_id == StudyVersion.id)
    rows = await session.execute(
        select(StudyVersion.config_hash, StudyVersion.added_at, joined.scalar_subquery())
        .where(StudyVersion.study_id == study_id)
        .order_by(StudyVersion.id)
    )
    return [VersionEntry(number, *row) for number, row in enumerate(rows, 1)]


async def read_version(session: AsyncSession, version_id: int) -> Study:
    """The study as it was when its participants joined."""
    rows = await session.execute(
        select(StudyVersion.config_json, StudyVersion.config_hash).where(
            StudyVersion.id == version_id
        )
    )
    found = rows.one_or_none()
    if found is None:
        raise LookupError(f"no study version {version_id}")
    return read_stored(*found)


async def list_versions(session: AsyncSession, study_id: str) -> dict[str, Study]:
    """All versions of a study by hash, oldest first."""
    rows = await session.execute(
        select(StudyVersion.config_json, StudyVersion.config_hash)
        .where(StudyVersion.study_id == study_id)
        .order_by(StudyVersion.id)
    )
    return {config_hash: read_stored(text, config_hash) for text, config_hash in rows}


async def list_same_design(session: AsyncSession, study: Study) -> list[int]:
    """Ids of the versions whose places are the same as this study's: same orders, same seed.

    A mended text keeps the balance of those who joined before; other conditions begin a new one.
    """
    rows = await session.execute(
        select(StudyVersion.id, StudyVersion.config_json, StudyVersion.config_hash).where(
            StudyVersion.study_id == study.study_id
        )
    )
    same = []
    for version_id, text, config_hash in rows:
        other = study if config_hash == study.config_hash else read_stored(text, config_hash)
        if (other.orders, other.seed) == (study.orders, study.seed):
            same.append(version_id)
    return same


async def list_ids(session: AsyncSession, study_id: str) -> dict[int, Study]:
    """All versions of a study by their id."""
    rows = await session.execute(
        select(StudyVersion.id, StudyVersion.config_json, StudyVersion.config_hash)
        .where(StudyVersion.study_id == study_id)
        .order_by(StudyVersion.id)
    )
    return {number: read_stored(text, config_hash) for number, text, config_hash in rows}
