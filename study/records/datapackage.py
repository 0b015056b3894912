"""The export's own description, datapackage.json: a table schema for every file.

After the Data Package standard, version 1 (https://specs.frictionlessdata.io), so that
`frictionless validate` checks columns, types, keys, references, sizes and hashes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from types import MappingProxyType
from typing import Any

from study.records.cells import Kind, Table

_TYPES: Mapping[Kind, Mapping[str, Any]] = MappingProxyType(
    {
        "text": {"type": "string"},
        "integer": {"type": "integer"},
        "number": {"type": "number"},
        "boolean": {"type": "boolean", "trueValues": ["true"], "falseValues": ["false"]},
        "time": {"type": "datetime"},
    }
)


@dataclass(frozen=True)
class WrittenFile:
    """A table as it was written into the bundle."""

    table: Table
    path: str
    rows: int
    size_bytes: int
    sha256: str

    @property
    def name(self) -> str:
        """Its name among the resources: the path without endings."""
        return self.path.removesuffix(".gz").removesuffix(".csv").lower()


def describe_package(
    study_id: str, title: str, made_at: datetime, files: Iterable[WrittenFile]
) -> dict[str, Any]:
    """The whole of datapackage.json."""
    written = list(files)
    held = {file.table.name for file in written}
    return {
        "profile": "data-package",
        "name": f"varil-{study_id}",
        "title": title,
        "created": made_at.isoformat(timespec="seconds").replace("+00:00", "Z"),
        "resources": [_describe_file(file, held) for file in written],
    }


def _describe_file(file: WrittenFile, held: set[str]) -> dict[str, Any]:
    described = {
        "name": file.name,
        "path": file.path,
        "profile": "tabular-data-resource",
        "description": file.table.meaning,
        "format": "csv",
        "mediatype": "text/csv",
        "encoding": "utf-8",
        "bytes": file.size_bytes,
        "hash": f"sha256:{file.sha256}",
        "rows": file.rows,
        "schema": _describe_table(file.table, held),
    }
    return described | ({"compression": "gz"} if file.path.endswith(".gz") else {})


def _describe_table(table: Table, held: set[str]) -> dict[str, Any]:
    fields = []
    for column in table.columns:
        field = {"name": column.name, **_TYPES[column.kind], "description": column.meaning}
        fields.append(field | ({"unit": column.unit} if column.unit else {}))
    schema: dict[str, Any] = {"fields": fields, "missingValues": [""]}
    if table.key:
        schema["primaryKey"] = list(table.key)
    references = [
        {"fields": [name], "reference": {"resource": other, "fields": [name]}}
        for name, other in table.refers
        if other in held
    ]
    return schema | ({"foreignKeys": references} if references else {})
