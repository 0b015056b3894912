"""The discrepancies of a run that is under way, counted pair by pair.

The same figures as `discrepancies.measure` gives, for the lines that need no look back over the
whole dataset: the policy's own, ARROCH's and nothing at all.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from study.learning.dataset import Pair
from study.learning.discrepancies import Discrepancies

LINES = ("policy", "arroch", "all_off")
RATES = ("off_rate", "hamming_rate", "shown_share")
_DIGITS = 6


class Curve:
    """Counts per line and iteration; `lines` by name, each with arrays int64[iterations]."""

    def __init__(self, iterations: int) -> None:
        self.lines = {
            name: Discrepancies(*(np.zeros(iterations, np.int64) for _ in range(4)))
            for name in LINES
        }

    def add(self, pair: Pair) -> None:
        """Count one pair."""
        robot = pair.domain == 0
        for name, proposal in (
            ("policy", pair.proposal),
            ("arroch", 7 if robot else 0),
            ("all_off", 0),
        ):
            line, j = self.lines[name], pair.iteration
            line.compared[j] += (7 & pair.drawn).bit_count()
            line.disable[j] += (proposal & ~pair.box & pair.drawn).bit_count()
            line.enable[j] += (~proposal & pair.box & pair.drawn).bit_count()
            line.shown[j] += (proposal & pair.drawn).bit_count()

    def to_json(self, first: int, end: int) -> dict[str, Any]:
        """The lines' counts and rates from iteration `first` to the one before `end`."""
        return {name: _describe(line, first, end) for name, line in self.lines.items()}


def _describe(line: Discrepancies, first: int, end: int) -> dict[str, list[int] | list[float]]:
    span = slice(first, end)
    parts = (line.disable, line.disable + line.enable, line.shown)
    whole = np.maximum(line.compared[span], 1)
    rates = {
        rate: [round(share, _DIGITS) for share in (part[span] / whole).tolist()]
        for rate, part in zip(RATES, parts, strict=True)
    }
    counts = {"disable": line.disable[span].tolist(), "enable": line.enable[span].tolist()}
    return {**counts, **rates}
