"""Versions of studies: once stored, a version never changes."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.inserting import insert_new
from server.store.tables import StudyVersion
from study.config import Study


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


async def read_version(session: AsyncSession, version_id: int) -> Study:
    """The study as it was when its participants joined."""
    text = await session.scalar(
        select(StudyVersion.config_json).where(StudyVersion.id == version_id)
    )
    if text is None:
        raise LookupError(f"no study version {version_id}")
    return Study.model_validate_json(text)


async def list_versions(session: AsyncSession, study_id: str) -> dict[str, Study]:
    """All versions of a study by hash, oldest first."""
    rows = await session.execute(
        select(StudyVersion.config_hash, StudyVersion.config_json)
        .where(StudyVersion.study_id == study_id)
        .order_by(StudyVersion.id)
    )
    return {hash_: Study.model_validate_json(text) for hash_, text in rows}
