"""What a learning run is set to: every free choice in PolicyUp, named and validated."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, NoReturn, Self

from study.ar.thresholds import Thresholds
from study.errors import InvalidValue

BOX_MODES = ("follow", "independent")
LABEL_SOURCES = ("boxes", "events", "confirmed")
PAIR_UNITS = ("agent", "snapshot")
PAIRS_PER_ITERATION = 25
SNAPSHOT_TICKS = 120
RECENT_TICKS = 240
MOST_ITERATIONS = 2000
LARGEST_SEED = 2**53

_EXPONENTIAL = re.compile(r"exponential\((0?\.\d+|0|1|1\.0*)\)")


@dataclass(frozen=True)
class LearningSettings:
    """Settings of one run. Fixed by the paper: 25 pairs an iteration, 240 iterations, 4 s.

    beta: `linear` (1 - j/J), `exponential(p)` (p to the power of j) or `first_only`.
    box_mode: a box takes a new proposal whenever that changes (`follow`), or keeps what the expert
    set last (`independent`).
    label_source: all agents at each snapshot (`boxes`), those edited in the last 8 s (`events`),
    or those edited or marked right in the last 8 s (`confirmed`).
    pair_unit: what counts as one of the 25: an `agent`'s pair, or a whole `snapshot`.
    All but `boxes` as the source of labels are our choice; the paper leaves them open.
    """

    iterations: int = 240
    beta: str = "linear"
    box_mode: str = "follow"
    label_source: str = "boxes"
    pair_unit: str = "agent"
    classifier: str = "svm"
    seed: int = 0
    thresholds: Thresholds = field(default_factory=Thresholds)

    def __post_init__(self) -> None:
        for name, least, most in (
            ("iterations", 1, MOST_ITERATIONS),
            ("seed", 0, LARGEST_SEED),
        ):
            value = getattr(self, name)
            if type(value) is not int or not least <= value <= most:
                _refuse(name, value, f"a whole number from {least} to {most}")
        for name, allowed in (
            ("box_mode", BOX_MODES),
            ("label_source", LABEL_SOURCES),
            ("pair_unit", PAIR_UNITS),
        ):
            if getattr(self, name) not in allowed:
                _refuse(name, getattr(self, name), f"one of {', '.join(allowed)}")
        if self.beta not in ("linear", "first_only") and not _EXPONENTIAL.fullmatch(self.beta):
            _refuse("beta", self.beta, "linear, first_only or exponential(p) with p from 0 to 1")

    def beta_of(self, j: int) -> float:
        """Probability that iteration j shows an agent as the expert has set it."""
        if self.beta == "linear":
            return 1.0 - j / self.iterations
        if self.beta == "first_only":
            return 1.0 if j == 0 else 0.0
        found = _EXPONENTIAL.fullmatch(self.beta)
        return float(found.group(1)) ** j if found else 0.0

    def to_json(self) -> dict[str, Any]:
        """The settings by name, for a policy's file; the thresholds stand there already."""
        record = asdict(self)
        del record["thresholds"]
        return record

    @classmethod
    def from_json(cls, record: Mapping[str, Any], thresholds: Mapping[str, Any]) -> Self:
        """The settings written by `to_json`, with the thresholds that were stored beside them."""
        return cls(**record, thresholds=Thresholds.from_json(thresholds))


def _refuse(name: str, value: object, wanted: str) -> NoReturn:
    raise InvalidValue(f"{value!r} is not allowed", where=name, next_step=f"Give {wanted}.")
