"""What staff read of a study as a whole: rows, checks, places in the design, versions, counts."""

from __future__ import annotations

from dataclasses import dataclass

from server.store.dashboard import LedgerEntry, count_crowds, list_blocks, list_ledger
from server.store.data_checks import (
    count_rows,
    find_foreign_versions,
    find_incomplete,
    find_unmeasured,
)
from server.store.engine import Database
from server.store.participants import count_by_status
from server.store.studies import VersionEntry, list_entries, list_ids
from study.config import Study

BLOCKS = 24
"""So many of the newest blocks are listed."""


@dataclass(frozen=True)
class Stored:
    """Rows by table and mode, and what does not fit together: (what should be, what is not so)."""

    rows: dict[str, dict[str, int]]
    checks: list[tuple[str, list[str]]]


@dataclass(frozen=True)
class Places:
    """The newest blocks (block -> order -> status of who holds it) and a page of the ledger."""

    blocks: dict[int, dict[int, str]]
    ledger: list[LedgerEntry]
    total: int


@dataclass(frozen=True)
class DataDesk:
    """Reads only; each question is answered from one view of the data."""

    database: Database

    async def examine(self, study_id: str) -> Stored:
        """How much is stored, and what of it does not fit together."""
        async with self.database.reading() as session:
            rows = await count_rows(session, study_id)
            versions = await list_ids(session, study_id)
            wanted = {number: count_wanted(study) for number, study in versions.items()}
            checks = [
                (
                    "Every completed trial has its measures and its final state",
                    await find_unmeasured(session, study_id),
                ),
                (
                    "Everybody who completed has every trial and every required answer",
                    await find_incomplete(session, study_id, wanted),
                ),
                (
                    "Every trial has the version that its participant joined",
                    await find_foreign_versions(session, study_id),
                ),
            ]
        return Stored(rows, checks)

    async def list_places(self, study_id: str, mode: str, *, offset: int, limit: int) -> Places:
        """Who holds which place, and how that came about."""
        async with self.database.reading() as session:
            blocks = await list_blocks(session, study_id, mode, newest=BLOCKS)
            ledger, total = await list_ledger(session, study_id, mode, offset=offset, limit=limit)
        return Places(blocks, ledger, total)

    async def list_versions(self, study_id: str) -> tuple[list[VersionEntry], int]:
        """The study's versions, oldest first, and how many completed it who were not live."""
        async with self.database.reading() as session:
            versions = await list_entries(session, study_id)
            crowds = await count_crowds(session, study_id)
        tried = sum(c.number for c in crowds if c.status == "completed" and c.mode != "live")
        return versions, tried

    async def count_statuses(self) -> dict[tuple[str, str, str], int]:
        """Participants by study, mode and status."""
        async with self.database.reading() as session:
            return await count_by_status(session)


def count_wanted(study: Study) -> tuple[int, int]:
    """How many answers and trials a completed participant of this version has at least."""
    needed = 0
    for kind in ("consent", "demographics", "questionnaire", "final", "comments"):
        asked = sum(bool(item.required) for _, item in study.items_asked(kind))
        needed += asked * (len(study.conditions) if kind == "questionnaire" else 1)
    return needed, len(study.conditions)
