"""Guards the figures of a trial's quality: from events and inputs alone, nothing made up."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.records.events import EVENT_KINDS, JournalEvent, check_event
from study.records.quality import QualityFold, TrialQuality, quantile

START = datetime(2026, 1, 1, tzinfo=UTC)
Told = tuple[float, str, dict[str, Any]]
SHOWN = {"visible": True, "focused": True, "locked": True}


def at(seconds: float) -> datetime:
    return START + timedelta(seconds=seconds)


def fold(told: list[Told], end_s: float) -> TrialQuality:
    gathered = QualityFold()
    for number, (second, kind, data) in enumerate(told):
        check_event(kind, data)
        gathered.add_event(JournalEvent(number, 0, kind, at(second), data))
    return gathered.finish(at(end_s), 1.5, 20.0)


def test_time_counts_as_the_page_last_said() -> None:
    figures = fold(
        [
            (0, "connected", {}),
            (1, "attention", SHOWN | {"visible": False}),
            (5, "attention", SHOWN),
            (10, "started", {"seq": 0}),
            (20, "attention", SHOWN | {"focused": False, "locked": False}),
            (22, "attention", SHOWN | {"visible": False, "focused": False}),
            (25, "paused", {"reason": "silent"}),
            (30, "attention", SHOWN),
            (31, "attention", SHOWN | {"locked": False}),
            (32, "started", {"seq": 0}),
            (40, "disconnected", {"code": 1006}),
            (41, "connected", {}),
        ],
        50,
    )
    assert (figures.hidden_s, figures.unfocused_s) == (8.0, 10.0)
    assert (figures.pauses, figures.paused_s, figures.connections) == (1, 7.0, 2)
    assert figures.pointer_lock_losses == 1
    assert (figures.tick_late_p99_ms, figures.tick_late_max_ms) == (1.5, 20.0)


def test_reports_are_taken_together() -> None:
    report = {"fps": "60 30", "rtt_ms": "10.0", "long_frames": 1, "longest_frame_ms": 80.0}
    other = {"fps": "50", "rtt_ms": "30.0 20.0", "long_frames": 2, "longest_frame_ms": 70}
    figures = fold([(0, "quality", report), (5, "quality", other)], 6)
    assert (figures.frame_rate_median_hz, figures.rtt_median_ms) == (50.0, 20.0)
    assert figures.frame_rate_p5_hz == pytest.approx(32.0)
    assert figures.rtt_p95_ms == pytest.approx(29.0)
    assert (figures.long_frames, figures.longest_frame_ms, figures.reports) == (3, 80.0, 2)


def test_what_was_not_measured_is_nothing_rather_than_zero() -> None:
    figures = fold([(0, "started", {"seq": 0})], 9)
    measured = {name: value for name, value in vars(figures).items() if value is not None}
    assert set(measured) == {
        "pauses",
        "paused_s",
        "idle_s",
        "tick_late_p99_ms",
        "tick_late_max_ms",
        "connections",
        "reports",
    }


def test_a_server_that_was_killed_is_a_pause() -> None:
    told: list[Told] = [
        (0, "started", {"seq": 0}),
        (10, "opened", {"resumed": True}),
        (60, "started", {"seq": 0}),
    ]
    figures = fold(told, 70)
    assert (figures.pauses, figures.paused_s) == (1, 50.0)


def test_idle_is_five_seconds_without_a_key_or_a_turn() -> None:
    gathered = QualityFold()
    stretches = [(30, 1, 7), (149, 0, 7), (1, 0, 8), (150, 0, 8), (1, 4, 8), (200, 0, 8)]
    for ticks, keys, yaw in stretches:
        for _ in range(ticks):
            gathered.add_frames(((keys, yaw),))
    for _ in range(100):
        gathered.add_frames(())
    assert gathered.finish(START, None, None).idle_s == pytest.approx((150 + 300) / 30, abs=0.001)


@given(st.lists(st.floats(0, 1e6), min_size=1, max_size=30), st.floats(0, 1))
def test_a_quantile_lies_between_the_figures(figures: list[float], share: float) -> None:
    found = quantile(figures, share)
    assert found is not None
    assert min(figures) - 1e-6 <= found <= max(figures) + 1e-6
    assert quantile([], share) is None


def test_every_event_may_come_at_any_time() -> None:
    """Kinds that say nothing about quality only pass the time."""
    gathered = QualityFold()
    for number, kind in enumerate(EVENT_KINDS.values()):
        if kind.name not in ("quality", "attention"):
            gathered.add_event(JournalEvent(number, 0, kind.name, at(number), {}))
    assert gathered.finish(at(99), None, None).reports == 0
