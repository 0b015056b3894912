"""How numbers read in sentences and tables."""

from __future__ import annotations

from collections.abc import Sequence

Cell = str | int | float | bool | None
NO_VALUE = "–"
ALPHA = 0.05


def number(value: Cell) -> str:
    """Three significant digits or more: 2154, 21.5, 2.15, 0.215; a dash for nothing."""
    if value is None:
        return NO_VALUE
    size = abs(float(value))
    decimals = 0 if size >= 100 else 1 if size >= 10 else 2 if size >= 1 else 3
    return f"{float(value):.{decimals}f}".replace("-", "\N{MINUS SIGN}")


def plain(value: Cell) -> str:
    """A whole number as it is, any other as `number` tells it."""
    if value is not None and float(value).is_integer():
        return f"{float(value):.0f}".replace("-", "\N{MINUS SIGN}")
    return number(value)


def chance(p: Cell) -> str:
    """A p-value: three decimals, or `< 0.001`; four where three would round it up to 0.050."""
    if p is None:
        return NO_VALUE
    value = float(p)
    if value < 0.001:
        return "< 0.001"
    return f"{value:.4f}" if ALPHA - 0.0005 <= value < ALPHA else f"{value:.3f}"


def equals(p: float | None) -> str:
    """A p-value after its sign, as in `p = 0.012`."""
    told = chance(p)
    return told if told.startswith("<") else f"= {told}"


def interval(values: Sequence[Cell]) -> str:
    """A value with its bounds, or alone where it has none."""
    value, low, high = values
    if low is None or high is None:
        return number(value)
    return f"{number(value)} [{number(low)}, {number(high)}]"


def verdict(p: float | None) -> str:
    """What a p-value allows to say: a difference, or that none was shown."""
    return "a significant difference" if p is not None and p < ALPHA else "no difference was shown"


def count(amount: int, noun: str) -> str:
    """A number with its noun: `no participant`, `1 participant`, `2 participants`."""
    return f"{amount or 'no'} {noun}{'s' if amount > 1 else ''}"


def mark_title(title: str, mark: str) -> str:
    """A figure's title with whose data it shows on a line of its own; live data need none."""
    return f"{title}\n{mark}" if mark else title


def unformatted(text: str) -> str:
    """The text as a figure's label that the drawing library does not take for a formula."""
    return text.replace("$", r"\$")


def capitalise(text: str) -> str:
    """The text with its first letter as a capital, the rest untouched."""
    return text[:1].upper() + text[1:]
