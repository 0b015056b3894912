"""The export: one zip of tidy tables with their description, written while the data are read.

All of it comes from one consistent view of the data. A zip that was cut off has no directory at
its end, so no program opens it by mistake.
"""

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from server.export.items import all_conditions, study_items
from server.export.sources import Sources
from server.export.telemetry import Telemetry
from server.export.texts import ORIGINS, make_readme
from server.export.zip_stream import ZipStream
from server.kernel_cache import open_kernel_cache
from server.settings import Settings
from server.store.engine import Database
from server.store.export_rows import Pages, Selection
from server.store.policies import UsedPolicy, list_used, read_policies
from server.store.schema import check_schema
from server.store.studies import list_versions
from study.errors import UnknownStudy
from study.records.cells import Table
from study.records.codebook import CODEBOOK, codebook_rows
from study.records.datapackage import describe_package
from study.records.observations import PANEL_IDS, TELEMETRY
from study.records.tables import (
    EVENTS,
    EXPERT_LABELS,
    LEGS,
    NOTES,
    PARTICIPANTS,
    QUALITY,
    RESPONSES,
    ROBOTS,
    TRIALS,
)
from study.records.wide import wide_table

MODES = ("live", "pilot", "bot")
YIELD_BYTES = 64 * 1024
STDOUT = Path("-")


@dataclass(frozen=True)
class ExportOptions:
    """What to export. `panel_ids` and `telemetry` are left out unless asked for."""

    study_id: str
    mode: str | None = None
    telemetry: bool = False
    panel_ids: bool = False

    @property
    def selection(self) -> Selection:
        """Whose rows."""
        return Selection(self.study_id, self.mode)


async def stream_export(
    database: Database, options: ExportOptions, counts: dict[str, int] | None = None
) -> AsyncIterator[bytes]:
    """Pieces of the zip; `counts` receives the number of rows by table.

    Raises `UnknownStudy` if nobody ever joined or registered this study here.
    """
    counts = {} if counts is None else counts
    async with database.reading() as session:
        versions = await list_versions(session, options.study_id)
        if not versions:
            raise UnknownStudy(options.study_id)
        policies = await list_used(session, options.study_id, options.mode)
        bundle = _Bundle(options, Sources(session, options.selection, versions), policies)
        async for piece in bundle.write_tables(counts):
            yield piece
        documents = await read_policies(session, [used.sha256 for used in policies])
        for sha256, document in sorted(documents.items()):
            bundle.stream.add_text(f"policies/{sha256}.json", document)
        if options.telemetry:
            async for piece in bundle.write_telemetry(Telemetry(session)):
                yield piece
            counts["telemetry"] = bundle.count_telemetry()
    bundle.write_codebook()
    bundle.write_descriptions()
    yield bundle.stream.finish()


async def write_export(settings: Settings, options: ExportOptions, out: Path) -> dict[str, int]:
    """Write the zip to a file, which appears only when it is complete; returns rows by table.

    `-` is standard output.
    """
    if options.telemetry:
        open_kernel_cache()
    database = Database(settings.database)
    counts: dict[str, int] = {}
    try:
        await check_schema(database)
        if out == STDOUT:
            async for piece in stream_export(database, options, counts):
                await asyncio.to_thread(sys.stdout.buffer.write, piece)
            sys.stdout.buffer.flush()
            return counts
        part = out.with_name(out.name + ".part")
        try:
            with await asyncio.to_thread(part.open, "wb") as file:
                async for piece in stream_export(database, options, counts):
                    file.write(piece)
            part.replace(out)
        finally:
            part.unlink(missing_ok=True)
    finally:
        await database.close()
    return counts


class _Bundle:
    """The zip while it is being written."""

    def __init__(
        self, options: ExportOptions, sources: Sources, policies: Sequence[UsedPolicy]
    ) -> None:
        self.stream = ZipStream()
        self._options = options
        self._sources = sources
        self._policies = policies
        versions = sources.versions
        self._items = [
            item for hash_, study in versions.items() for item in study_items(hash_, study)
        ]
        self._wide = wide_table(self._items, all_conditions(versions))
        self._failed: list[str] = []

    async def write_tables(self, counts: dict[str, int]) -> AsyncIterator[bytes]:
        """Pieces of the zip while the tables are written; everybody else has a turn in between."""
        for table, pages in self._tables():
            zipped = self.stream.begin_table(table)
            async for page in pages:
                zipped.add_rows(page)
                if piece := self.stream.take(YIELD_BYTES):
                    yield piece
                await asyncio.sleep(0)
            zipped.close()
            counts[table.name] = zipped.rows

    async def write_telemetry(self, telemetry: Telemetry) -> AsyncIterator[bytes]:
        """Pieces of the zip while trials are re-simulated; one that cannot be is named."""
        async for trial in self._sources.ended_trials():
            trial_id = trial["trial_id"]
            rows = await telemetry.read(trial_id)
            if isinstance(rows, str):
                self._failed.append(f"{trial_id}: {rows}")
                continue
            self.stream.add_packed_table(TELEMETRY, f"telemetry/{trial_id}.csv.gz", rows)
            if piece := self.stream.take(YIELD_BYTES):
                yield piece

    def count_telemetry(self) -> int:
        """How many trials have telemetry."""
        return sum(file.table is TELEMETRY for file in self.stream.tables)

    def write_codebook(self) -> None:
        """The meaning of every column, event and item."""
        further = [(self._wide.file, self._wide), (CODEBOOK.file, CODEBOOK)]
        if self._options.panel_ids:
            further.append((PANEL_IDS.file, PANEL_IDS))
        if self._options.telemetry:
            further.append(("telemetry/*.csv.gz", TELEMETRY))
        rows = list(codebook_rows(self._items, further))
        named = (f"{used.sha256}={used.name} ({ORIGINS[used.origin]})" for used in self._policies)
        levels = "|".join(named)
        for row in rows:
            if row["name"] == "policy_sha256":
                row["levels"] = levels
        zipped = self.stream.begin_table(CODEBOOK)
        zipped.add_rows(rows)
        zipped.close()

    def write_descriptions(self) -> None:
        """datapackage.json, README.txt and, last, the manifest."""
        options, versions, stream = self._options, self._sources.versions, self.stream
        title = list(versions.values())[-1].title
        package = describe_package(options.study_id, title, datetime.now(UTC), stream.tables)
        text = json.dumps(package, indent=1, ensure_ascii=False)
        stream.add_text("datapackage.json", text + "\n")
        names = [table.path for table in stream.tables if table.table is not TELEMETRY]
        readme = make_readme(
            options.study_id, options.mode, names, list(versions), self._policies, self._failed
        )
        stream.add_text("README.txt", readme)
        stream.add_text("MANIFEST.sha256", "".join(stream.manifest))

    def _tables(self) -> list[tuple[Table, Pages]]:
        """The tables in their order in the zip, each with where its rows come from."""
        sources, wide = self._sources, self._wide
        tables = [
            (PARTICIPANTS, sources.people()),
            (TRIALS, sources.trials()),
            (ROBOTS, sources.parts("robots")),
            (LEGS, sources.parts("legs")),
            (RESPONSES, sources.answers()),
            (wide, sources.wide(wide)),
            (EVENTS, sources.parts("events")),
            (QUALITY, sources.quality()),
            (EXPERT_LABELS, sources.labels(used.sha256 for used in self._policies)),
            (NOTES, sources.notes()),
        ]
        if self._options.panel_ids:
            tables.append((PANEL_IDS, sources.panel_ids()))
        return tables
