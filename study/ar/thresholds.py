"""The thresholds that cut continuous quantities into the agents' discrete states.

None is published with the paper; all are our choice, named, validated and stored with each policy.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields

from study.errors import PolicyError


@dataclass(frozen=True)
class Thresholds:
    """Borders of the agents' states; a value at a border belongs to the higher class.

    Lengths of `close_m` and `far_m` are lattice path lengths from the human.
    """

    close_m: float = 5.0
    far_m: float = 15.0
    many_tasks: int = 2
    medium_wait_s: float = 10.0
    long_wait_s: float = 30.0
    nearby_m: float = 3.5
    many_nearby: int = 3
    many_shown_share: float = 0.5
    many_waiting: int = 1

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not math.isfinite(value) or value < 0:
                raise PolicyError(
                    f"{value!r} is not allowed",
                    where=f"thresholds.{entry.name}",
                    next_step="Give a finite number that is not negative.",
                )
        self._check_order("close_m", "far_m")
        self._check_order("medium_wait_s", "long_wait_s")

    def _check_order(self, lower: str, upper: str) -> None:
        if getattr(self, lower) >= getattr(self, upper):
            raise PolicyError(
                f"{lower} ({getattr(self, lower)}) must be below {upper} ({getattr(self, upper)})",
                where="thresholds",
                next_step="Correct one of the two.",
            )

    def to_json(self) -> dict[str, float | int]:
        """The thresholds by name."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: object) -> Thresholds:
        """Read thresholds; PolicyError names a missing, unknown or wrong entry."""
        if not isinstance(data, Mapping):
            raise PolicyError(
                "an object with the thresholds by name was expected", where="thresholds"
            )
        wanted = {entry.name: entry.type for entry in fields(cls)}
        for name in (*wanted, *data):
            if name not in wanted or name not in data:
                what = "is missing" if name in wanted else "is not known"
                raise PolicyError(
                    f"“{name}” {what}",
                    where="thresholds",
                    next_step=f"Give exactly: {', '.join(wanted)}.",
                )
            if isinstance(data[name], bool) or not isinstance(data[name], int | float):
                raise PolicyError(f"{data[name]!r} is no number", where=f"thresholds.{name}")
            if wanted[name] == "int" and not isinstance(data[name], int):
                raise PolicyError(f"{data[name]!r} is no whole number", where=f"thresholds.{name}")
        return cls(**data)
