"""What a table of the export is made of: columns, and how a value becomes a cell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Literal

Kind = Literal["text", "integer", "number", "boolean", "time"]
Value = str | int | float | bool | datetime | None

_FORMULA_STARTS = frozenset("=+-@\t\r\n＝＋－＠")


@dataclass(frozen=True)
class Column:
    """One column: its type, unit ("" = none) and meaning."""

    name: str
    kind: Kind
    meaning: str
    unit: str = ""


@dataclass(frozen=True)
class Table:
    """One file of the export.

    `key`: the columns that tell its rows apart; `refers`: columns that must occur in another
    table's column of the same name, with that table's name.
    """

    name: str
    meaning: str
    columns: tuple[Column, ...]
    key: tuple[str, ...] = ()
    refers: tuple[tuple[str, str], ...] = ()

    @property
    def file(self) -> str:
        """Its name in the zip."""
        return f"{self.name}.csv"

    @property
    def header(self) -> list[str]:
        """The names of its columns."""
        return [column.name for column in self.columns]


def format_row(table: Table, row: Mapping[str, Value]) -> list[str]:
    """The row's cells in the table's order; KeyError if a column is missing."""
    return [format_cell(column, row[column.name]) for column in table.columns]


def row_formatter(table: Table) -> Callable[[Mapping[str, Any]], list[str]]:
    """`format_row` for many rows of one table."""
    cells = [(column.name, _FORMATS[column.kind]) for column in table.columns]

    def form(row: Mapping[str, Any]) -> list[str]:
        return ["" if (value := row[name]) is None else make(value) for name, make in cells]

    return form


def format_cell(column: Column, value: Value) -> str:
    """A value as text: ISO-8601 UTC, true/false, shortest exact numbers, empty for nothing."""
    return "" if value is None else _FORMATS[column.kind](value)


def neutralise_formula(text: str) -> str:
    """The text, with an apostrophe before it if a spreadsheet would run it as a formula."""
    return f"'{text}" if text[:1] in _FORMULA_STARTS else text


def _format_plain(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


def _format_time(value: datetime) -> str:
    return value.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


_FORMATS: Mapping[Kind, Callable[[Any], str]] = {
    "text": lambda value: neutralise_formula(str(value)),
    "integer": _format_plain,
    "number": _format_plain,
    "boolean": _format_plain,
    "time": _format_time,
}
