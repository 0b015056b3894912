"""What staff did: written down as it happens, and looked up again."""

from __future__ import annotations

from dataclasses import dataclass

from server.desks.trials import Clock, utc_now
from server.store.audit import AuditWanted, Entry, add_audit, list_audited, search_audit
from server.store.engine import Database


@dataclass(frozen=True)
class AuditDesk:
    """Owns the audit. An act that changes data is noted in that act's own transaction instead."""

    database: Database
    clock: Clock = utc_now

    async def note(self, user_name: str, action: str, detail: str = "") -> None:
        """Write down what a member of staff did that changes no data of a study."""
        async with self.database.writing() as session:
            await add_audit(session, user_name, action, detail, self.clock())

    async def search(
        self, wanted: AuditWanted, *, offset: int, limit: int
    ) -> tuple[list[str], list[Entry], int]:
        """Who ever did something; one page of the entries wanted, newest first; how many."""
        async with self.database.reading() as session:
            names = await list_audited(session)
            entries, total = await search_audit(session, wanted, offset=offset, limit=limit)
        return names, entries, total
