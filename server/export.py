"""The export: one zip of tidy tables, written while it is read from the database.

All tables come from one consistent view of the data.
"""

from __future__ import annotations

import asyncio
import csv
import hashlib
import io
import zipfile
from collections.abc import AsyncIterator, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from server.settings import Settings
from server.store import export_rows
from server.store.engine import Database
from server.store.policies import UsedPolicy, list_used
from server.store.schema import check_schema
from server.store.studies import list_versions
from study.config import Study
from study.errors import UnknownStudy
from study.protocol.device import FIELDS, FIGURES
from study.protocol.flow import step_kind
from study.protocol.items import answer_label, levels_of, unit_of
from study.records.codebook import CODEBOOK, ItemEntry, codebook_rows
from study.records.tables import LEGS, PARTICIPANTS, RESPONSES, ROBOTS, TRIALS, Table, format_row

MODES = ("live", "pilot", "bot")
YIELD_BYTES = 64 * 1024
_README = """Export of the study “{study_id}” ({mode})

One table per file; codebook.csv tells what every column and every item means.
Times are ISO-8601 in UTC; seconds and metres stand in the columns' names (_s, _m).
Tables are joined by participant_code and trial_id.

- participants.csv has a row for everybody who joined. Of those who withdrew nothing else is given.
- trials.csv has the trials after the practice; analyse those whose status is completed.
- Rows whose mode is not live come from pilots or simulated participants.
- In text columns a cell that a spreadsheet would run as a formula begins with an apostrophe.
- MANIFEST.sha256 holds a checksum per file; check with: sha256sum -c MANIFEST.sha256

Versions of the study in this export: {versions}

Policies that decided about the display in these trials, by policy_sha256:
{policies}
"""
_ORIGINS = {
    "initial": "initial, taught by nobody",
    "people": "learned from people",
    "simulated": "learned from simulated people",
}


class ZipStream:
    """A zip that is taken away in pieces while it is being written."""

    def __init__(self) -> None:
        self._pieces = _Pieces()
        self._zip = zipfile.ZipFile(self._pieces, "w", zipfile.ZIP_DEFLATED)
        self.manifest: list[str] = []

    def add_file(self, name: str) -> _ZippedFile:
        """Begin a file; it is to be closed before the next one begins."""
        return _ZippedFile(self, self._zip, name)

    def add_text(self, name: str, text: str) -> None:
        """Add a whole file."""
        file = self.add_file(name)
        file.write(text)
        file.close()

    def finish(self) -> bytes:
        """Write the directory and give out the last piece."""
        self._zip.close()
        return self.take()

    def take(self, at_least: int = 0) -> bytes:
        """What was written since the last call, or nothing if that is less than `at_least`."""
        return self._pieces.take(at_least)


class _Pieces:
    """The unseekable file that `zipfile` writes to."""

    mode = "wb"

    def __init__(self) -> None:
        self._held = bytearray()

    def write(self, data: bytes, /) -> int:
        self._held += data
        return len(data)

    def flush(self) -> None:
        """Nothing is kept back."""

    def close(self) -> None:
        """Nothing is to be closed."""

    def take(self, at_least: int) -> bytes:
        if len(self._held) < at_least:
            return b""
        taken = bytes(self._held)
        self._held.clear()
        return taken


class _ZippedFile:
    """One file of the zip, hashed as it is written."""

    def __init__(self, owner: ZipStream, archive: zipfile.ZipFile, name: str) -> None:
        self._owner, self._name = owner, name
        self._digest = hashlib.sha256()
        self._out = archive.open(name, "w", force_zip64=True)

    def write(self, text: str) -> None:
        data = text.encode()
        self._digest.update(data)
        self._out.write(data)

    def close(self) -> None:
        self._out.close()
        self._owner.manifest.append(f"{self._digest.hexdigest()}  {self._name}\n")


async def stream_export(
    database: Database, study_id: str, mode: str | None, counts: dict[str, int] | None = None
) -> AsyncIterator[bytes]:
    """Pieces of the zip; `counts` receives the number of rows by table.

    Raises `UnknownStudy` if nobody ever joined or registered this study here.
    """
    counts = {} if counts is None else counts
    async with database.reading() as session:
        versions = await list_versions(session, study_id)
        if not versions:
            raise UnknownStudy(study_id)
        stream = ZipStream()
        sources = (
            (PARTICIPANTS, export_rows.participant_rows(session, study_id, mode)),
            (TRIALS, export_rows.trial_rows(session, study_id, mode)),
            (ROBOTS, export_rows.robot_rows(session, study_id, mode)),
            (LEGS, export_rows.leg_rows(session, study_id, mode)),
            (RESPONSES, export_rows.response_rows(session, study_id, mode)),
        )
        for table, rows in sources:
            file = stream.add_file(table.file)
            file.write(_csv_line(table.header))
            counts[table.name] = 0
            async for row in rows:
                counts[table.name] += 1
                complete = _complete_row(table, row, versions)
                file.write(_csv_line(format_row(table, complete)))
                if piece := stream.take(YIELD_BYTES):
                    yield piece
            file.close()
        policies = await list_used(session, study_id, mode)
    _add_descriptions(stream, study_id, mode, versions, policies)
    yield stream.finish()


async def write_export(
    settings: Settings, study_id: str, mode: str | None, out: Path
) -> dict[str, int]:
    """Write the zip to a file, which appears only when it is complete; returns rows by table."""
    database = Database(settings.database)
    counts: dict[str, int] = {}
    part = out.with_name(out.name + ".part")
    try:
        await check_schema(database)
        with await asyncio.to_thread(part.open, "wb") as file:
            async for piece in stream_export(database, study_id, mode, counts):
                file.write(piece)
        part.replace(out)
    finally:
        part.unlink(missing_ok=True)
        await database.close()
    return counts


def study_items(config_hash: str, study: Study) -> Iterator[ItemEntry]:
    """Every item that a version of a study asks, in the order of its pages."""
    for name in FIELDS:
        kind = "number" if name in FIGURES else "flag"
        yield ItemEntry(config_hash, "browser_check", name, kind, "measured by the browser check")
    for instrument in study.all_instruments:
        for item in instrument.items:
            yield ItemEntry(
                config_hash,
                instrument.name,
                item.name,
                item.kind,
                item.label,
                levels_of(item),
                unit_of(item),
            )


def _add_descriptions(
    stream: ZipStream,
    study_id: str,
    mode: str | None,
    versions: Mapping[str, Study],
    policies: Sequence[UsedPolicy],
) -> None:
    file = stream.add_file(CODEBOOK.file)
    file.write(_csv_line(CODEBOOK.header))
    items = (entry for hash_, study in versions.items() for entry in study_items(hash_, study))
    for row in codebook_rows(items):
        if row["name"] == "policy_sha256":
            levels = (f"{used.sha256}={used.name} ({_ORIGINS[used.origin]})" for used in policies)
            row["levels"] = "|".join(levels)
        file.write(_csv_line(format_row(CODEBOOK, row)))
    file.close()
    shown_mode = f"mode {mode} only" if mode else "all modes"
    named = [f"- {used.sha256}: “{used.name}”, {_ORIGINS[used.origin]}" for used in policies]
    text = _README.format(
        study_id=study_id,
        mode=shown_mode,
        versions=", ".join(versions),
        policies="\n".join(named) or "- none",
    )
    stream.add_text("README.txt", text)
    stream.add_text("MANIFEST.sha256", "".join(stream.manifest))


def _complete_row(
    table: Table, row: dict[str, Any], versions: Mapping[str, Study]
) -> dict[str, Any]:
    """Add what is not stored because it follows from the version of the study."""
    study = versions[row["config_hash"]]
    if table is PARTICIPANTS:
        row["status"] = row["outcome"] or "active"
        order = row["order_index"]
        row["condition_order"] = None if order is None else ">".join(study.orders[order])
    if table is RESPONSES:
        kind, position = step_kind(row["step"])
        order = row["order_index"]
        known = position is not None and order is not None
        row["position"] = position
        row["condition"] = study.orders[order][position - 1] if known and position else None
        row["instrument"] = kind.replace("-", "_")
        row["label"] = row["value"]
        for instrument, item in study.items_asked(kind):
            if item.name == row["item"]:
                row["instrument"] = instrument.name
                row["label"] = answer_label(item, row["value"])
    return row


def _csv_line(cells: list[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    return out.getvalue()
