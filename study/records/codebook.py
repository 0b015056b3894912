"""The codebook: every column of every table, and every item that a study asks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from study.records.tables import TABLES, Column, Table

CODEBOOK = Table(
    "codebook",
    "what every column and every item means",
    (
        Column("file", "text", "the file that holds it"),
        Column("name", "text", "name of the column, or instrument.item"),
        Column("type", "text", "text, integer, number, boolean or time; kind of item"),
        Column("unit", "text", "the unit, where there is one"),
        Column("meaning", "text", "what it is; of an item, its wording"),
        Column("levels", "text", "allowed values, as value=label joined by |"),
        Column("config_hash", "text", "the version of the study that asks it; empty for columns"),
    ),
)


@dataclass(frozen=True)
class ItemEntry:
    """An item of a study's version as the codebook lists it."""

    config_hash: str
    instrument: str
    item: str
    kind: str
    wording: str
    levels: tuple[tuple[str, str], ...] = ()
    unit: str = ""


def codebook_rows(items: Iterable[ItemEntry]) -> Iterator[dict[str, str]]:
    """Rows of `CODEBOOK`: the columns of all tables, then the items in the order given."""
    for table in TABLES.values():
        for column in table.columns:
            yield {
                "file": table.file,
                "name": column.name,
                "type": column.kind,
                "unit": column.unit,
                "meaning": column.meaning,
                "levels": "true|false" if column.kind == "boolean" else "",
                "config_hash": "",
            }
    for entry in items:
        yield {
            "file": "responses.csv",
            "name": f"{entry.instrument}.{entry.item}",
            "type": entry.kind,
            "unit": entry.unit,
            "meaning": entry.wording,
            "levels": "|".join(f"{value}={label}" for value, label in entry.levels),
            "config_hash": entry.config_hash,
        }
