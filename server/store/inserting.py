"""Inserting rows that may be there already: the first one stays, nobody waits for an error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.ext.asyncio import AsyncSession

from server.store.base import Base


async def insert_new(
    session: AsyncSession, table: type[Base], rows: Sequence[dict[str, Any]]
) -> int:
    """Insert those rows whose keys are not taken yet; of a single row, tells whether it was new."""
    if not rows:
        return 0
    if session.get_bind().dialect.name == "postgresql":
        statement: Any = postgresql.insert(table).on_conflict_do_nothing()
    else:
        statement = sqlite.insert(table).on_conflict_do_nothing()
    if len(rows) == 1:
        done = await session.execute(statement.values(rows[0]))
        return int(cast("Any", done).rowcount)
    await session.execute(statement, list(rows))
    return len(rows)
