"""How findings are worded. Every sentence for every outcome was written before the run."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from server.results.findings import REFERENCES, Mode
from study.analysis.claims import (
    FLAT,
    STEEP,
    Fall,
    Verdict,
    judge_discrepancies,
    judge_left,
    judge_shorter,
)
from study.analysis.intervals import Interval
from study.analysis.paired import Difference

NAMES: Mapping[str, str] = MappingProxyType({"arroch": "ARROCH", "crmiar": "CRMIAR"})

FALLS: Mapping[Verdict, str] = MappingProxyType(
    {
        Verdict.FOUND: (
            "**Found.** VARIL's count falls from {own}; ARROCH's goes from {reference}, which is "
            "within a quarter of where it began."
        ),
        Verdict.NOT_FOUND: (
            "**Not found.** VARIL's count goes from {own}; ARROCH's from {reference}. The claim "
            "asked for a fall to half or less, and for ARROCH within a quarter of where it began."
        ),
        Verdict.OPPOSITE: (
            "**The opposite was found.** VARIL's count rises, from {own}; ARROCH's goes from "
            "{reference}."
        ),
    }
)
SHORTER: Mapping[Verdict, str] = MappingProxyType(
    {
        Verdict.FOUND: (
            "**Found.** Teams wait less under VARIL; waiting differs {pairs}. Both intervals lie "
            "below 0, and more than half of the teams wait less."
        ),
        Verdict.NOT_FOUND: (
            "**Not found.** Waiting differs {pairs}. The claim asked for both intervals below 0 "
            "and for more than half of the teams."
        ),
        Verdict.OPPOSITE: (
            "**The opposite was found.** Teams wait longer under VARIL; waiting differs "
            "{pairs}. Both intervals lie above 0, and less than half of the teams wait less."
        ),
    }
)
LEFT: Mapping[Verdict, str] = MappingProxyType(
    {
        Verdict.FOUND: "**Found.** From P1 to {last} the mean moves by {change}: to the left.",
        Verdict.NOT_FOUND: (
            "**Not found.** From P1 to {last} the mean moves by {change}, an interval that holds 0."
        ),
        Verdict.OPPOSITE: (
            "**The opposite was found.** From P1 to {last} the mean moves by {change}: to the "
            "right."
        ),
    }
)


def judge(mode: Mode) -> dict[str, Verdict]:
    """The verdict on each claim for a box mode."""
    last = mode.steps[-1][2]
    if last is None:
        raise ValueError("a mode without learned policies has no last one")
    return {
        "i": judge_discrepancies(*mode.falls["disable"]),
        "ii": judge_shorter(pairs["sum_wait_s"] for pairs in mode.shorter.values()),
        "iii": judge_left(last),
    }


def tell_fall(mode: Mode) -> str:
    """Claim (i) for a box mode."""
    own, reference = mode.falls["disable"]
    said = FALLS[judge(mode)["i"]]
    return said.format(own=fall(own, 1), reference=fall(reference, 1))


def tell_shorter(mode: Mode) -> str:
    """Claim (ii) for a box mode."""
    pairs = "; ".join(
        f"from {NAMES[name]}'s by {seconds(mode.shorter[name]['sum_wait_s'])}, "
        f"{share(mode.shorter[name]['sum_wait_s'].shorter)} of teams wait less"
        for name in REFERENCES
    )
    return SHORTER[judge(mode)["ii"]].format(pairs=pairs)


def tell_left(mode: Mode) -> str:
    """Claim (iii) for a box mode."""
    name, _, pair = mode.steps[-1]
    change = seconds(pair) if pair else ""
    return LEFT[judge(mode)["iii"]].format(last=name, change=change)


def seconds(pair: Difference) -> str:
    """A difference as “+12 s [-3, +27]”."""
    return f"{signed(pair.seconds.mean)} s {bounds(pair.seconds)}"


def bounds(interval: Interval, digits: int = 0) -> str:
    """An interval's bounds, with signs."""
    return f"[{signed(interval.low, digits)}, {signed(interval.high, digits)}]"


def share(interval: Interval) -> str:
    """A share and its bounds in per cent."""
    low, high = (round(100 * value) for value in (interval.low, interval.high))
    return f"{round(100 * interval.mean)} % [{low}, {high}]"


def plain(interval: Interval) -> str:
    """A mean and its bounds, without signs."""
    return f"{interval.mean:.0f} [{interval.low:.0f}, {interval.high:.0f}]"


def fall(found: Fall, digits: int) -> str:
    """“18.2 to 7.9 (change -10.3 [-11.0, -9.5], -57 %)”."""
    change = f"{signed(found.change.mean, digits)} {bounds(found.change, digits)}"
    part = f", {signed(100 * found.share)} %" if found.early else ""
    return f"{found.early:.{digits}f} to {found.late:.{digits}f} (change {change}{part})"


def signed(value: float, digits: int = 0) -> str:
    """A number with its sign, but never “-0”."""
    rounded = round(value, digits)
    return f"{rounded:+.{digits}f}" if rounded else f"{0:.{digits}f}"


RULES = (
    f"(i) is *found* if VARIL's count falls with its whole interval, from the first sixth of the "
    f"iterations to {STEEP:g} of that or less in the last sixth, while the mean of ARROCH's stays "
    f"within {100 * FLAT:g} %. (ii) is *found* if against ARROCH and against CRMIAR the whole "
    "interval of the mean difference lies below 0 and that of the share of teams that wait less "
    "lies above one half. (iii) is *found* if the whole interval of the mean difference between "
    "the last policy and P1 lies below 0. The *opposite* is found where the same holds the other "
    "way round (for (i): where VARIL's count rises with its whole interval)."
)
