"""Inserting rows that may be there already: the first one stays, nobody waits for an error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.tables import Base


async def insert_new(
    session: AsyncSession, table: type[Base], rows: Sequence[dict[str, Any]]
) -> None:
    """Insert those rows whose keys are not taken yet."""
    if not rows:
        return
    if session.get_bind().dialect.name == "postgresql":
        await session.execute(postgresql.insert(table).on_conflict_do_nothing(), list(rows))
    else:
        await session.execute(sqlite.insert(table).on_conflict_do_nothing(), list(rows))
