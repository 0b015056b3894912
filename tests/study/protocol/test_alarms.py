"""Guards the alarms: each at its threshold and by itself, the worst first, none without cause."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.protocol.alarms import VitalSigns, raise_alarms

CALM = VitalSigns(ticks=1000, late_p99_ms=10.0, drop_out=0.2, judged=100, spread=2, is_live=True)
"""Every figure at its threshold, none beyond it."""
BEYOND: dict[str, tuple[dict[str, Any], str, str]] = {
    "storage": ({"storage_failing_s": 0.0}, "problem", "Nothing could be stored for 0 s"),
    "policy": ({"policy_is_simulated": True}, "problem", "learned from simulated people"),
    "lateness": ({"late_p99_ms": 10.6}, "warning", "more than 11 ms late"),
    "drop-out": ({"drop_out": 0.21}, "warning", "21 % of those who passed the practice left"),
    "away": ({"away": 1}, "warning", "1 participant was not heard of"),
    "balance": ({"spread": 3}, "warning", "has 3 participants more than the emptiest"),
    "time scale": ({"time_scale": 4.0}, "warning", "Worlds run 4 times as fast"),
}


def test_nothing_is_raised_at_the_thresholds() -> None:
    """Nor without any figures, as before the first participant."""
    assert raise_alarms(CALM) == []
    assert raise_alarms(VitalSigns()) == []


@pytest.mark.parametrize("name", BEYOND)
def test_each_alarm_is_raised_just_beyond_its_threshold(name: str) -> None:
    """That one alone, with what to do."""
    change, level, title = BEYOND[name]
    (alarm,) = raise_alarms(replace(CALM, **change))
    assert alarm.level == level
    assert title in alarm.title
    assert len(alarm.advice) > 20
    assert alarm.advice.endswith(".")


@given(st.sets(st.sampled_from(sorted(BEYOND))))
def test_alarms_do_not_hide_each_other_and_problems_come_first(names: set[str]) -> None:
    signs = CALM
    for name in names:
        signs = replace(signs, **BEYOND[name][0])
    alarms = raise_alarms(signs)
    titles = [alarm.title for alarm in alarms]
    assert len(alarms) == len(names)
    assert all(any(BEYOND[name][2] in title for title in titles) for name in names)
    levels = [alarm.level for alarm in alarms]
    assert levels == sorted(levels, key=["problem", "warning"].index)


@given(st.floats(0, 200), st.floats(0, 1), st.integers(0, 20), st.integers(0, 20))
def test_the_thresholds_are_where_they_are_said_to_be(
    late_ms: float, drop_out: float, judged: int, spread: int
) -> None:
    """10 ms of 99 % of the ticks, a fifth of at least five, orders two apart."""
    signs = VitalSigns(
        late_p99_ms=late_ms, ticks=1, drop_out=drop_out, judged=judged, spread=spread
    )
    titles = " ".join(alarm.title for alarm in raise_alarms(signs))
    assert ("ms late" in titles) == (late_ms > 10.0)
    assert ("left before the end" in titles) == (drop_out > 0.2 and judged >= 5)
    assert ("fullest order" in titles) == (spread > 2)


@pytest.mark.parametrize(
    "change",
    [
        {"ticks": 0, "late_p99_ms": 500.0},
        {"drop_out": None},
        {"drop_out": 1.0, "judged": 4},
        {"policy_is_simulated": True, "is_live": False},
    ],
)
def test_what_nothing_rests_on_raises_nothing(change: dict[str, Any]) -> None:
    """No tick yet, nobody to judge by, four to judge by, pilots with a simulated policy."""
    assert raise_alarms(replace(CALM, **change)) == []


def test_several_who_are_away_are_counted() -> None:
    (alarm,) = raise_alarms(replace(CALM, away=3))
    assert alarm.title == "3 participants were not heard of for five minutes"
