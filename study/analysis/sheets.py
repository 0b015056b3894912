"""Tables of a report: full columns for the file, a few readable ones for the page.

Each names the rows behind it: the file of the export, the filter, and how many there were.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from types import MappingProxyType
from typing import Any, Literal

from study.analysis.cases import MEASURES, label_condition
from study.analysis.drawing import Chart
from study.analysis.wording import NO_VALUE, Cell, chance, count, interval, number, plain

ViewKind = Literal[
    "text",
    "code",
    "measure",
    "difference",
    "quotient",
    "number",
    "plain",
    "p",
    "interval",
    "bounds",
    "list",
]


@dataclass(frozen=True)
class RowsBehind:
    """Which rows of the export a table or figure was computed from.

    `parts`: rows and participants by what was measured, where these differ; the totals then count
    each row once per measure and each participant once.
    """

    file: str
    filter: str
    rows: int
    participants: int
    parts: tuple[tuple[str, int, int], ...] = ()

    @property
    def sentence(self) -> str:
        """`trials.csv where ...: 72 rows of 24 participants`."""
        parts = self.parts or (("", self.rows, self.participants),)
        told = (
            f"{count(rows, 'row')} of {count(people, 'participant')}"
            + (f" for the {what}" if what else "")
            for what, rows, people in parts
        )
        return f"{self.file} where {self.filter}: {'; '.join(told)}"


@dataclass(frozen=True)
class View:
    """One column of the page: its title, how it reads, and the file's columns that it shows."""

    title: str
    kind: ViewKind
    fields: tuple[str, ...]

    @property
    def is_figure(self) -> bool:
        """Whether it holds figures, which stand right-aligned."""
        return self.kind not in {"text", "code", "measure", "difference", "quotient"}


@dataclass(frozen=True)
class Sheet:
    """A table. `header` and `rows` make the file `tables/<name>.csv`; `views` the page."""

    name: str
    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    views: tuple[View, ...]
    behind: RowsBehind
    notes: tuple[str, ...] = ()

    @property
    def shown(self) -> list[list[str]]:
        """The cells of the page, row by row."""
        lines = (dict(zip(self.header, row, strict=True)) for row in self.rows)
        return [[show(view, line) for view in self.views] for line in lines]

    @property
    def groups(self) -> list[list[list[str]]]:
        """The page's rows, neighbours with the same first cell together."""
        return [list(group) for _, group in groupby(self.shown, key=lambda line: line[0])]

    @property
    def records(self) -> list[dict[str, Cell]]:
        """The rows with their columns' names."""
        return [dict(zip(self.header, row, strict=True)) for row in self.rows]


@dataclass(frozen=True)
class Picture:
    """A figure: `figures/<name>.svg` and `.pdf`; its numbers are `tables/figure_<name>.csv`."""

    name: str
    caption: str
    chart: Chart
    behind: RowsBehind
    is_small: bool = False


@dataclass(frozen=True)
class Section:
    """A part of the report: sentences, what was found or not tested, then tables and figures."""

    name: str
    heading: str
    sentences: tuple[str, ...]
    blocks: tuple[Sheet | Picture, ...] = ()
    findings: tuple[str, ...] = ()


def make_sheet(
    name: str,
    title: str,
    records: Iterable[Mapping[str, Any]],
    header: Sequence[str],
    views: Sequence[View],
    behind: RowsBehind,
) -> Sheet:
    """A sheet from records, of which only the header's columns are taken."""
    rows = tuple(tuple(record[column] for column in header) for record in records)
    return Sheet(name, title, tuple(header), rows, tuple(views), behind)


def show(view: View, line: Mapping[str, Cell]) -> str:
    """The text of one cell of the page."""
    values = [line[field] for field in view.fields]
    return _SHOW[view.kind](values)


def _text(values: Sequence[Cell]) -> str:
    return ", ".join(NO_VALUE if value in (None, "") else str(value) for value in values)


def _shortest(value: Cell) -> str:
    return NO_VALUE if value is None else f"{float(value):g}"


_SHOW: Mapping[ViewKind, Callable[[Sequence[Cell]], str]] = MappingProxyType(
    {
        "text": _text,
        "code": _text,
        "measure": lambda values: MEASURES.get(str(values[0]), str(values[0])),
        "difference": lambda values: " − ".join(label_condition(str(value)) for value in values),
        "quotient": lambda values: " / ".join(label_condition(str(value)) for value in values),
        "number": lambda values: number(values[0]),
        "plain": lambda values: plain(values[0]),
        "p": lambda values: chance(values[0]),
        "interval": interval,
        "bounds": lambda values: " to ".join(plain(value) for value in values),
        "list": lambda values: ", ".join(_shortest(value) for value in values),
    }
)
