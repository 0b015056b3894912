"""Holm's correction for testing several hypotheses at once (Holm 1979)."""

from __future__ import annotations

from collections.abc import Sequence


def adjust_holm(p_values: Sequence[float | None]) -> tuple[float | None, ...]:
    """Adjusted p-values in the given order; None (a test that could not be made) stays None.

    The smallest p is multiplied by the number of tests m, the next by m - 1, and so on; none may
    be smaller than the one before it, nor above 1.
    """
    known = sorted((p, place) for place, p in enumerate(p_values) if p is not None)
    adjusted: list[float | None] = [None] * len(p_values)
    highest = 0.0
    for rank, (p, place) in enumerate(known):
        highest = max(highest, min(1.0, (len(known) - rank) * p))
        adjusted[place] = highest
    return tuple(adjusted)
