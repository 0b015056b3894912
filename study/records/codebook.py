"""The codebook: every column of every table, every kind of event, every item that a study asks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from study.records.cells import Column, Table
from study.records.events import EVENT_KINDS
from study.records.observations import EVENTS
from study.records.tables import TABLES

CODEBOOK = Table(
    "codebook",
    "what every column and every item means",
    (
        Column("file", "text", "the file that holds it"),
        Column("name", "text", "name of the column, or instrument.item"),
        Column("type", "text", "text, integer, number, boolean or time; kind of event or item"),
        Column("unit", "text", "the unit, where there is one"),
        Column("meaning", "text", "what it is; of an item, its wording"),
        Column("levels", "text", "allowed values, as value=label joined by |"),
        Column("config_hash", "text", "the version of the study that asks it; empty for columns"),
    ),
)


@dataclass(frozen=True)
class ItemEntry:
    """An item of a study's version as the codebook lists it.

    `repeated`: asked after each trial. `whole`: every answer that can be stored is a whole number.
    """

    config_hash: str
    instrument: str
    item: str
    kind: str
    wording: str
    levels: tuple[tuple[str, str], ...] = ()
    unit: str = ""
    repeated: bool = False
    whole: bool = False


def codebook_rows(
    items: Iterable[ItemEntry], further: Iterable[tuple[str, Table]] = ()
) -> Iterator[dict[str, str]]:
    """Rows of `CODEBOOK`: columns of all tables, kinds of events, items in the order given.

    `further` are tables with their file names that this export holds besides those in `TABLES`.
    """
    for file, table in (*((table.file, table) for table in TABLES.values()), *further):
        for column in table.columns:
            levels = "true|false" if column.kind == "boolean" else ""
            yield _row(file, column.name, column.kind, column.unit, column.meaning, levels)
    for kind in EVENT_KINDS.values():
        yield _row(EVENTS.file, f"kind={kind.name}", "event", "", kind.meaning)
        for field in kind.fields:
            name = f"data.{kind.name}.{field.name}"
            yield _row(EVENTS.file, name, field.type, field.unit, field.meaning)
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


def _row(
    file: str, name: str, kind: str, unit: str, meaning: str, levels: str = ""
) -> dict[str, str]:
    return {
        "file": file,
        "name": name,
        "type": kind,
        "unit": unit,
        "meaning": meaning,
        "levels": levels,
        "config_hash": "",
    }
