"""The audit: what staff did, added to and never changed."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import func, select
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import AuditEntry

Entry = tuple[datetime, str, str, str]
"""When, who, what, detail."""


@dataclass(frozen=True)
class AuditWanted:
    """Which entries of the audit a list shows; empty texts stand for all."""

    user_name: str = ""
    text: str = ""


async def add_audit(
    session: AsyncSession, user_name: str, action: str, detail: str, now: datetime
) -> None:
    """Note what a member of staff did."""
    session.add(AuditEntry(at=now, user_name=user_name[:64], action=action, detail=detail[:200]))
    await session.flush()


async def search_audit(
    session: AsyncSession, wanted: AuditWanted, *, offset: int, limit: int
) -> tuple[list[Entry], int]:
    """One page of the audit, newest first, and how many entries there are."""
    here = []
    if wanted.user_name:
        here.append(AuditEntry.user_name == wanted.user_name)
    if wanted.text:
        text = AuditEntry.action + " " + AuditEntry.detail
        here.append(text.icontains(wanted.text.strip(), autoescape=True))
    count = await session.scalar(select(func.count()).select_from(AuditEntry).where(*here))
    rows = await session.execute(
        select(AuditEntry.at, AuditEntry.user_name, AuditEntry.action, AuditEntry.detail)
        .where(*here)
        .order_by(AuditEntry.id.desc())
        .offset(offset)
        .limit(limit)
    )
    return [(at, name, action, detail) for at, name, action, detail in rows], count or 0


async def list_audited(session: AsyncSession) -> list[str]:
    """Everybody who ever did something, by name."""
    return list(
        await session.scalars(
            select(AuditEntry.user_name).distinct().order_by(AuditEntry.user_name)
        )
    )
