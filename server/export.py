"""The export."""

from __future__ import annotations

from collections.abc import AsyncIterator

from server.store.engine import Database

MODES = ("live", "pilot", "bot")


async def stream_export(
    database: Database, study_id: str, mode: str | None = None
) -> AsyncIterator[bytes]:
    """The zip."""
    yield b""
