"""A zip of text tables that is taken away in pieces while it is being written."""

from __future__ import annotations

import csv
import gzip
import hashlib
import io
import zipfile
from collections.abc import Iterable, Mapping
from typing import Any

from study.records.cells import Table, row_formatter
from study.records.datapackage import WrittenFile


class ZipStream:
    """One file after the other; `manifest` holds a line per file, `tables` what is in them."""

    def __init__(self) -> None:
        self._pieces = _Pieces()
        self._zip = zipfile.ZipFile(self._pieces, "w", zipfile.ZIP_DEFLATED)
        self.manifest: list[str] = []
        self.tables: list[WrittenFile] = []

    def begin_table(self, table: Table) -> ZippedTable:
        """Begin a table; it is to be closed before the next file begins."""
        return ZippedTable(self, self._zip, table)

    def add_text(self, name: str, text: str) -> None:
        """Add a whole file."""
        data = text.encode()
        self._zip.writestr(name, data)
        self.note(name, hashlib.sha256(data).hexdigest())

    def add_packed_table(self, table: Table, path: str, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add a whole table, packed by gzip; the same rows give the same bytes."""
        text, form, count = io.StringIO(), row_formatter(table), 0
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(table.header)
        for row in rows:
            writer.writerow(form(row))
            count += 1
        packed = gzip.compress(text.getvalue().encode(), mtime=0)
        digest = hashlib.sha256(packed).hexdigest()
        self._zip.writestr(zipfile.ZipInfo(path, date_time=(1980, 1, 1, 0, 0, 0)), packed)
        self.note(path, digest)
        self.tables.append(WrittenFile(table, path, count, len(packed), digest))

    def note(self, name: str, digest: str) -> None:
        """Enter a file into the manifest."""
        self.manifest.append(f"{digest}  {name}\n")

    def finish(self) -> bytes:
        """Write the directory and give out the last piece."""
        self._zip.close()
        return self.take()

    def take(self, at_least: int = 0) -> bytes:
        """What was written since the last call, or nothing if that is less than `at_least`."""
        return self._pieces.take(at_least)


class ZippedTable:
    """One table of the zip, hashed as it is written."""

    def __init__(self, owner: ZipStream, archive: zipfile.ZipFile, table: Table) -> None:
        self._owner, self._table = owner, table
        self._digest = hashlib.sha256()
        self._out = archive.open(table.file, "w", force_zip64=True)
        self._form = row_formatter(table)
        self._size_bytes = self.rows = 0
        self._write([table.header])

    def add_rows(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Write rows; KeyError if one lacks a column."""
        cells = [self._form(row) for row in rows]
        self.rows += len(cells)
        self._write(cells)

    def close(self) -> None:
        """The table is complete."""
        self._out.close()
        digest = self._digest.hexdigest()
        self._owner.note(self._table.file, digest)
        self._owner.tables.append(
            WrittenFile(self._table, self._table.file, self.rows, self._size_bytes, digest)
        )

    def _write(self, cells: list[list[str]]) -> None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(cells)
        data = text.getvalue().encode()
        self._size_bytes += len(data)
        self._digest.update(data)
        self._out.write(data)


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
