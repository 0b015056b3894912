"""Tests of ordered answers: per item over all conditions, and per item and planned contrast."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

from study.analysis.cases import Item, correction_family
from study.analysis.designs import Design, Pairs, Untestable, require
from study.analysis.friedman import rank_conditions
from study.analysis.holm import adjust_holm
from study.analysis.signed_ranks import bound_rank_biserial, compare_ranks, rank_biserial

SEED = 20221214


@dataclass(frozen=True)
class ItemRanking:
    """Friedman's test of one item; `p_family` is Holm's over the items of its family."""

    instrument: str
    item: str
    n: int
    chi_squared: float | None = None
    df: int | None = None
    p: float | None = None
    p_family: float | None = None
    kendall_w: float | None = None
    note: str = ""


@dataclass(frozen=True)
class ItemPair:
    """Two conditions compared on one item by Wilcoxon's test with Pratt's zeros.

    `p_holm` is corrected over the planned contrasts of the item, `p_family` over those of all
    items of its family. What could not be tested is None, with a note.
    """

    instrument: str
    item: str
    first: str
    second: str
    n: int
    zeros: int | None = None
    rank_sum_positive: float | None = None
    rank_sum_negative: float | None = None
    z: float | None = None
    p: float | None = None
    p_normal: float | None = None
    p_holm: float | None = None
    p_family: float | None = None
    rank_biserial: float | None = None
    low: float | None = None
    high: float | None = None
    note: str = ""


def rank_items(designs: Mapping[Item, Design]) -> tuple[ItemRanking, ...]:
    """Friedman's test of every item, corrected over the items of its family."""
    found = [_rank(item, design) for item, design in designs.items()]
    for places in _families(tuple(designs), found):
        corrected = adjust_holm([found[k].p for k in places])
        for k, p in zip(places, corrected, strict=True):
            found[k] = replace(found[k], p_family=p)
    return tuple(found)


def compare_items(designs: Mapping[Item, Design], pairs: Pairs) -> tuple[ItemPair, ...]:
    """Wilcoxon's test of every item and pair; pairs that nobody planned carry no p-value."""
    found: list[ItemPair] = []
    for item, design in designs.items():
        own = [_compare(item, design, *pair) for pair in pairs.pairs]
        corrected = adjust_holm([one.p for one in own])
        found += [replace(one, p_holm=p) for one, p in zip(own, corrected, strict=True)]
    if not pairs.planned:
        return tuple(replace(one, p=None, p_normal=None, p_holm=None) for one in found)
    for places in _families(tuple(designs), found):
        corrected = adjust_holm([found[k].p for k in places])
        for k, p in zip(places, corrected, strict=True):
            found[k] = replace(found[k], p_family=p)
    return tuple(found)


def _families(items: tuple[Item, ...], found: Sequence[ItemRanking | ItemPair]) -> list[list[int]]:
    """Places of the results that are corrected together, a list per instrument."""
    families = []
    for instrument in dict.fromkeys(item.instrument for item in items):
        family = correction_family(items, instrument)
        families.append(
            [
                k
                for k, one in enumerate(found)
                if one.instrument == instrument and one.item in family
            ]
        )
    return families


def _rank(item: Item, design: Design) -> ItemRanking:
    start = ItemRanking(item.instrument, item.name, design.n)
    try:
        found = rank_conditions(design)
    except Untestable as error:
        return replace(start, note=error.what)
    return replace(
        start, chi_squared=found.chi_squared, df=found.df, p=found.p, kendall_w=found.kendall_w
    )


def _compare(item: Item, design: Design, first: str, second: str) -> ItemPair:
    start = ItemPair(item.instrument, item.name, first, second, design.n)
    try:
        require(design, 2)
    except Untestable as error:
        return replace(start, note=error.what)
    differences = design.differences(first, second)
    name = "/".join((item.instrument, item.name, first, second))
    low, high = bound_rank_biserial(differences, zlib.crc32(name.encode(), SEED))
    start = replace(start, rank_biserial=rank_biserial(differences), low=low, high=high)
    try:
        found = asdict(compare_ranks(differences))
    except Untestable as error:
        return replace(start, zeros=design.n, note=error.what)
    return replace(start, **found)
