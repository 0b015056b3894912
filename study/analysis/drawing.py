"""How every figure looks, and how it becomes SVG and PDF: the same numbers give the same bytes.

Colours are Okabe and Ito's, told apart also by colour-blind readers; lines differ in dashes too,
so colour is never the only signal. Figures belong to nobody's global state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

SIMULATED = "simulated people"
INK = "#17202a"
SOFT = "#51606e"
LINE = "#d3dbe1"
Dash = str | tuple[float, tuple[float, ...]]


@dataclass(frozen=True)
class Style:
    """Colour (hex), dashes and hatching of a group."""

    colour: str
    dash: Dash = "-"
    hatch: str = ""


STYLES: Mapping[str, Style] = MappingProxyType(
    {
        "varil": Style("#0072B2", "-", ""),
        "arroch": Style("#D55E00", "--", "///"),
        "crmiar": Style("#009E73", "-.", "..."),
        "none": Style("#7F8A94", ":", "\\\\\\"),
        "full": Style("#E69F00", (0.0, (6.0, 2.0, 1.0, 2.0, 1.0, 2.0)), "xxx"),
        "all_off": Style("#CC79A7", (0.0, (3.0, 1.0)), "---"),
        "no_ghost": Style("#56B4E9", (0.0, (1.0, 1.0)), "+++"),
        "majority": Style("#E69F00", (0.0, (5.0, 1.0, 1.0, 1.0)), "ooo"),
        "per_element": Style("#009E73", (0.0, (4.0, 2.0)), "|||"),
        "floor": Style(INK, ":", "**"),
    }
)
"""Conditions, controls and reference lines by name; `style_of` knows others by their place."""

_SPARE = ("#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#51606e")
_SPARE_DASHES: tuple[Dash, ...] = ("-", "--", "-.", ":")
_LOOK: Mapping[Any, Any] = MappingProxyType(
    {
        "svg.hashsalt": "varil",
        "svg.fonttype": "none",
        "pdf.fonttype": 42,
        "font.family": ["DejaVu Sans"],
        "font.size": 9.0,
        "axes.titlesize": 10.0,
        "axes.edgecolor": SOFT,
        "axes.labelcolor": INK,
        "xtick.color": SOFT,
        "ytick.color": SOFT,
        "text.color": INK,
    }
)


@dataclass(frozen=True)
class Chart:
    """A figure in both forms and the numbers that it shows, one row per mark or bin."""

    svg: bytes
    pdf: bytes
    header: tuple[str, ...]
    rows: tuple[tuple[str | int | float, ...], ...]


def style_of(name: str, place: int = 0) -> Style:
    """The style of a named group, else the spare style for its place among the groups."""
    if name in STYLES:
        return STYLES[name]
    dash = _SPARE_DASHES[place // len(_SPARE) % len(_SPARE_DASHES)]
    return Style(_SPARE[place % len(_SPARE)], dash)


def new_figure(
    width_in: float = 6.4,
    height_in: float = 4.0,
    *,
    rows: int = 1,
    columns: int = 1,
    share: bool = True,
) -> tuple[Figure, list[Axes]]:
    """An empty figure and its axes, row by row; `share`: x axes by column, y axes by row."""
    with mpl.rc_context(dict(_LOOK)):
        figure = Figure(figsize=(width_in, height_in), layout="constrained")
        grid = figure.subplots(
            rows,
            columns,
            squeeze=False,
            sharex="col" if share else "none",
            sharey="row" if share else "none",
        )
        axes = [axis for row in grid for axis in row]
        for axis in axes:
            axis.spines[["top", "right"]].set_visible(False)
            axis.grid(visible=True, color=LINE, linewidth=0.6)
            axis.set_axisbelow(True)
    return figure, axes


def finish_chart(
    figure: Figure,
    title: str,
    mark: str,
    header: Sequence[str],
    rows: Sequence[tuple[str | int | float, ...]],
) -> Chart:
    """Title the figure, say whose data it shows (`mark`, "" = nothing to say), return the chart."""
    with mpl.rc_context(dict(_LOOK)):
        figure.suptitle(f"{title} ({mark})" if mark else title)
        svg = _print(figure, "svg", {"Date": None, "Creator": "VARIL", "Title": title})
        figure.set_layout_engine("none")  # laid out once; both forms have the same places
        pdf = _print(figure, "pdf", {"CreationDate": None, "Creator": "VARIL", "Title": title})
    return Chart(svg, pdf, tuple(header), tuple(rows))


def _print(figure: Figure, form: str, metadata: dict[str, Any]) -> bytes:
    sheet = _Sheet()
    figure.savefig(sheet, format=form, metadata=metadata)  # type: ignore[arg-type]
    return bytes(sheet.data)


class _Sheet:
    """Takes a figure's bytes; asks for no file."""

    def __init__(self) -> None:
        self.data = bytearray()

    def write(self, data: bytes) -> int:
        """Append; TypeError for text, which tells the printer to encode."""
        self.data += data
        return len(data)

    def tell(self) -> int:
        """Bytes so far."""
        return len(self.data)

    def seek(self, position: int, whence: int = 0) -> int:
        """Only forward writing is needed."""
        raise OSError(f"a sheet is written from top to bottom, not from {position} ({whence})")

    def flush(self) -> None:
        """Nothing waits."""
