"""Guards the rules by which a claim of the paper counts as found, on both sides of each border."""

from __future__ import annotations

import numpy as np
import pytest

from study.analysis.claims import (
    Fall,
    Verdict,
    detectable_s,
    judge_discrepancies,
    judge_left,
    judge_shorter,
    measure_fall,
)
from study.analysis.intervals import Interval
from study.analysis.paired import Difference
from study.errors import InvalidValue


def test_a_fall_compares_the_first_and_the_last_sixth() -> None:
    series = np.array([[12.0] * 2 + [0.0] * 8 + [3.0] * 2, [8.0] * 2 + [0.0] * 8 + [1.0] * 2])
    found = measure_fall(series, 1)
    assert (found.early, found.late) == (10.0, 2.0)
    assert (found.change.mean, found.change.low, found.change.high) == (-8.0, -9.0, -7.0)
    assert found.share == pytest.approx(-0.8)
    with pytest.raises(InvalidValue, match="needs runs"):
        measure_fall(np.zeros((3, 0)), 1)


def fall(early: float, late: float, low: float, high: float) -> Fall:
    return Fall(early, late, Interval(late - early, low, high, 10))


FLAT = fall(20, 21, -1, 3)


@pytest.mark.parametrize(
    ("own", "reference", "verdict"),
    [
        (fall(20, 10, -12, -8), FLAT, Verdict.FOUND),
        (fall(20, 10.1, -12, -8), FLAT, Verdict.NOT_FOUND),  # not to half
        (fall(20, 9, -23, 1), FLAT, Verdict.NOT_FOUND),  # not with its whole interval
        (fall(20, 5, -16, -14), fall(20, 14.9, -6, -4), Verdict.NOT_FOUND),  # ARROCH falls too
        (fall(20, 24, 2, 6), FLAT, Verdict.OPPOSITE),
    ],
)
def test_discrepancies(own: Fall, reference: Fall, verdict: Verdict) -> None:
    assert judge_discrepancies(own, reference) is verdict


def pair(low: float, high: float, share_low: float = 0.6, share_high: float = 0.7) -> Difference:
    return Difference(
        "P6", "arroch", Interval((low + high) / 2, low, high, 250),
        Interval((share_low + share_high) / 2, share_low, share_high, 250), 1000.0, 10, 0,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("pairs", "verdict"),
    [
        ((pair(-9, -1), pair(-9, -1)), Verdict.FOUND),
        ((pair(-9, -1), pair(-9, 1)), Verdict.NOT_FOUND),
        ((pair(-9, -1), pair(-9, -1, 0.5)), Verdict.NOT_FOUND),  # most teams?
        ((pair(1, 9, 0.3, 0.4), pair(1, 9, 0.3, 0.4)), Verdict.OPPOSITE),
        ((pair(1, 9, 0.3, 0.4), pair(-9, -1)), Verdict.NOT_FOUND),
    ],
)
def test_waiting(pairs: tuple[Difference, ...], verdict: Verdict) -> None:
    assert judge_shorter(pairs) is verdict


def test_moving_left() -> None:
    verdicts = [judge_left(pair(*ends)) for ends in ((-9, -1), (-9, 1), (1, 9))]
    assert verdicts == [Verdict.FOUND, Verdict.NOT_FOUND, Verdict.OPPOSITE]


def test_what_can_be_detected_shrinks_with_the_root_of_the_number() -> None:
    draws = np.random.default_rng(1).normal(0, 150, 100_000)
    assert detectable_s(draws[:250]) == pytest.approx(2.8 * 150 / np.sqrt(250), rel=0.1)
    assert detectable_s(draws) == pytest.approx(2.8 * 150 / np.sqrt(100_000), rel=0.02)
    with pytest.raises(InvalidValue, match="two pairs"):
        detectable_s(draws[:1])
