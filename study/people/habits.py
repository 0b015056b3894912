"""How the simulated people of a run differ from one another, as one record passed by hand.

The parameters themselves stand in the versioned file; a sensitivity figure replaces some of them by
name. Nothing here is global: who gets no record has the defaults.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from study.errors import InvalidValue
from study.people.parameters import limits_of, parameters_of

BALLOON_BELIEFS = ("onset", "always")
WISHES = ("declutter", "inform")
VIEWS = ("worker", "above")


@dataclass(frozen=True)
class Habits:
    """What is set about simulated people. Errors: InvalidValue naming what is allowed.

    balloon_belief: for the believer a balloon counts only if it came on after the last visit
    (`onset`), or `always`.
    wish: what the expert `person` wants to be visible, see `study.people.wishes`.
    view: the picture which that expert looks at, the worker's or one from `above`.
    replaced: parameters with other values than the file's, as ("worker.decide_s", 2.7).
    """

    balloon_belief: str = "onset"
    wish: str = "declutter"
    view: str = "worker"
    replaced: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        for name, allowed in (
            ("balloon_belief", BALLOON_BELIEFS),
            ("wish", WISHES),
            ("view", VIEWS),
        ):
            if getattr(self, name) not in allowed:
                raise InvalidValue(
                    f"{getattr(self, name)!r} is not allowed",
                    where=name,
                    next_step=f"Use one of: {', '.join(allowed)}.",
                )
        for name, value in self.replaced:
            least, most = limits_of(name)
            if not (math.isfinite(value) and least <= value <= most):
                raise InvalidValue(
                    f"{value!r} is not allowed",
                    where=name,
                    next_step=f"Use a number from {least:g} to {most:g}.",
                )

    def values_of(self, person: str) -> dict[str, float]:
        """The parameters of the `worker` or the `expert` by name, with those replaced."""
        values = dict(parameters_of(person))
        for name, value in self.replaced:
            if name.startswith(f"{person}."):
                values[name.removeprefix(f"{person}.")] = float(value)
        return values

    def scaled(self, names: Iterable[str], factor: float) -> Habits:
        """The same habits with some parameters multiplied, each kept within its limits."""
        fresh = dict(self.replaced)
        for name in names:
            person, _, parameter = name.partition(".")
            least, most = limits_of(name)
            fresh[name] = min(most, max(least, self.values_of(person)[parameter] * factor))
        return dataclasses.replace(self, replaced=tuple(sorted(fresh.items())))

    def to_json(self) -> dict[str, Any]:
        """The habits by name, for a policy's file."""
        return {
            "balloon_belief": self.balloon_belief,
            "wish": self.wish,
            "view": self.view,
            "replaced": {name: float(value) for name, value in self.replaced},
        }
