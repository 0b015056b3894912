"""Staff accounts and the audit of what staff did."""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from datetime import datetime
from typing import Literal, cast

from sqlalchemy import func, select, update
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import User

Role = Literal["admin", "expert"]


@dataclass(frozen=True)
class StaffRecord:
    """A staff account as the server sees it. A new `session_key` ends all its sign-ins."""

    id: int
    name: str
    role: Role
    password_hash: str
    session_key: str


async def store_user(
    session: AsyncSession, name: str, role: Role, password_hash: str, now: datetime
) -> bool:
    """Add an account, or give an existing one this role and password; True if it is new."""
    key = secrets.token_hex(16)
    known = await session.scalar(select(User.id).where(User.name == name))
    if known is not None:
        await session.execute(
            update(User)
            .where(User.id == known)
            .values(role=role, password_hash=password_hash, session_key=key)
        )
        return False
    session.add(
        User(name=name, role=role, password_hash=password_hash, session_key=key, added_at=now)
    )
    await session.flush()
    return True


async def find_user(session: AsyncSession, name: str) -> StaffRecord | None:
    """The account with this name."""
    return _record(await session.scalar(select(User).where(User.name == name)))


async def read_user(session: AsyncSession, user_id: int) -> StaffRecord | None:
    """The account with this id."""
    return _record(await session.scalar(select(User).where(User.id == user_id)))


async def count_admins(session: AsyncSession) -> int:
    """Number of accounts with the role admin."""
    count = await session.scalar(select(func.count()).select_from(User).where(User.role == "admin"))
    return count or 0


def _record(row: User | None) -> StaffRecord | None:
    if row is None:
        return None
    return StaffRecord(row.id, row.name, cast("Role", row.role), row.password_hash, row.session_key)
