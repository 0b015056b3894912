"""What the expert `person` wants to be visible, judged from its picture alone [our choice].

Two rules, neither tuned; the outcome of learning depends on which is used.

declutter   a robot that waits: live location; nothing if the worker sees it itself near by, or if
            it stands in a crowd and another one there has waited longer
            one that arrives soon: live location and trajectory; the trajectory alone near the
            worker; live location and ghost in a crowd, where ribbons run into one another
            any other: nothing
inform      the same, but a robot that is busy elsewhere keeps its trajectory

Of a robot that is not in the picture nothing is judged, until it has been out of it for so long
that it may be waiting: then its live location is wanted. A station in the picture gets its balloon
if somebody was last seen waiting there, not too long ago, and the worker is not near.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from study.people.beliefs import ARRIVES, BUSY, GONE, WAITS

LIVE, GHOST, TRAJECTORY = 1, 2, 4
ALL = LIVE | GHOST | TRAJECTORY


class Impression(NamedTuple):
    """What the person makes of one robot in its picture. Distances and times as judged."""

    kind: int
    known: bool
    direct: bool
    placed: bool
    crowded: bool
    longest: bool
    away_m: float
    left_s: float
    unseen_s: float


class Wish(NamedTuple):
    """Elements wanted on, those it is about (others are left alone), and whether it is urgent."""

    on: int
    about: int
    urgent: bool = False


NO_WISH = Wish(0, 0)


def wish_robot(rule: str, seen: Impression, values: Mapping[str, float]) -> Wish:
    """Return what is wanted of a robot. `values`: the expert's parameters."""
    if not seen.known:
        return Wish(LIVE, LIVE) if seen.unseen_s > values["probe_s"] else NO_WISH
    near = seen.placed and seen.away_m < values["near_m"]
    if seen.kind == WAITS:
        hidden = (near and seen.direct) or (seen.crowded and not seen.longest)
        return Wish(0 if hidden else LIVE, ALL, urgent=True)
    if seen.kind == ARRIVES and seen.left_s <= values["soon_s"]:
        if near:
            return Wish(TRAJECTORY, ALL, urgent=True)
        return Wish(LIVE | (GHOST if seen.crowded else TRAJECTORY), ALL, urgent=True)
    busy = rule == "inform" and seen.kind != GONE
    return Wish(TRAJECTORY if busy else 0, ALL)


def wish_station(known: bool, somebody_waits: bool, near: bool) -> Wish:
    """Return what is wanted of a station."""
    return Wish(int(somebody_waits and not near), 1, urgent=True) if known else NO_WISH


def misjudge(kind: int) -> int:
    """Return the status a robot is mistaken for: a waiting or arriving one for a busy one, a busy
    one for one that waits."""
    return BUSY if kind in (WAITS, ARRIVES) else WAITS
