"""How good the conditions of a trial were: connection, picture, attention, pauses, idleness.

Everything but the server's lateness follows from the trial's events and inputs, so a trial that
goes on after a restart is judged as a whole. What was not measured is None, never 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from statistics import median

from study.records.events import JournalEvent
from study.warehouse.halls import TICK_HZ

IDLE_AFTER_S = 5.0
LONG_FRAME_MS = 50.0


@dataclass(frozen=True)
class TrialQuality:
    """One trial's figures; the names are columns of quality.csv."""

    rtt_median_ms: float | None
    rtt_p95_ms: float | None
    frame_rate_median_hz: float | None
    frame_rate_p5_hz: float | None
    long_frames: int | None
    longest_frame_ms: float | None
    hidden_s: float | None
    unfocused_s: float | None
    pointer_lock_losses: int | None
    pauses: int
    paused_s: float
    idle_s: float
    tick_late_p99_ms: float | None
    tick_late_max_ms: float | None
    connections: int
    reports: int


def quantile(figures: Sequence[float], share: float) -> float | None:
    """The figure that `share` of them do not exceed, between neighbours in proportion."""
    if not figures:
        return None
    ordered = sorted(figures)
    place = share * (len(ordered) - 1)
    low = int(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (ordered[high] - ordered[low]) * (place - low)


class QualityFold:
    """Gathers a trial's events and inputs as they come, and sums them up at its end."""

    def __init__(self) -> None:
        self._rtt_ms: list[float] = []
        self._frame_rates_hz: list[float] = []
        self._reports = self._long_frames = self._connections = 0
        self._longest_frame_ms = 0.0
        self._at: datetime | None = None
        self._has_started = self._is_paused = self._is_connected = self._is_told = False
        self._visible = self._focused = True
        self._locked = False
        self._hidden_s = self._unfocused_s = self._paused_s = 0.0
        self._losses = self._pauses = 0
        self._yaw = -1
        self._still_ticks = self._idle_ticks = 0

    def add_event(self, event: JournalEvent) -> None:
        """Take the next event; kinds that tell nothing about quality only pass the time."""
        self._pass_time(event.at_utc)
        kind, data = event.kind, event.data
        if kind == "quality":
            self._add_report(str(data["fps"]), str(data["rtt_ms"]))
            self._long_frames += int(data["long_frames"])
            longest_ms = float(data["longest_frame_ms"])
            self._longest_frame_ms = max(self._longest_frame_ms, longest_ms)
        elif kind == "attention":
            self._attend(bool(data["visible"]), bool(data["focused"]), bool(data["locked"]))
        elif kind == "started":
            self._has_started, self._is_paused = True, False
        elif kind == "paused" or (kind == "opened" and self._is_running):
            self._pauses += 1
            self._is_paused = True
        elif kind == "connected":
            self._connections += 1
            self._is_connected, self._locked = True, False
        elif kind == "disconnected":
            self._is_connected = False

    def add_frames(self, frames: Sequence[tuple[int, int]]) -> None:
        """Take what one tick consumed: no frame, or frames without a key or a turn, are idle."""
        for keys, yaw in frames:
            if keys or yaw != self._yaw:
                self._yaw = frames[-1][1]
                self._end_stillness()
                return
        self._still_ticks += 1

    def finish(
        self, at_utc: datetime, late_p99_ms: float | None, late_max_ms: float | None
    ) -> TrialQuality:
        """The figures of the trial that ends at this moment."""
        self._pass_time(at_utc)
        self._end_stillness()
        told = self._is_told
        return TrialQuality(
            rtt_median_ms=median(self._rtt_ms) if self._rtt_ms else None,
            rtt_p95_ms=quantile(self._rtt_ms, 0.95),
            frame_rate_median_hz=median(self._frame_rates_hz) if self._frame_rates_hz else None,
            frame_rate_p5_hz=quantile(self._frame_rates_hz, 0.05),
            long_frames=self._long_frames if self._reports else None,
            longest_frame_ms=self._longest_frame_ms if self._reports else None,
            hidden_s=round(self._hidden_s, 3) if told else None,
            unfocused_s=round(self._unfocused_s, 3) if told else None,
            pointer_lock_losses=self._losses if told else None,
            pauses=self._pauses,
            paused_s=round(self._paused_s, 3),
            idle_s=round(self._idle_ticks / TICK_HZ, 3),
            tick_late_p99_ms=late_p99_ms,
            tick_late_max_ms=late_max_ms,
            connections=self._connections,
            reports=self._reports,
        )

    @property
    def _is_running(self) -> bool:
        return self._has_started and not self._is_paused

    def _pass_time(self, at: datetime) -> None:
        """From the first start on, time counts as what the page last said of itself."""
        passed_s = (at - self._at).total_seconds() if self._at else 0.0
        self._at = at
        if passed_s <= 0.0 or not self._has_started:
            return
        if self._is_connected and not self._visible:
            self._hidden_s += passed_s
        if self._is_connected and not self._focused:
            self._unfocused_s += passed_s
        if self._is_paused:
            self._paused_s += passed_s

    def _add_report(self, frame_rates: str, rtts: str) -> None:
        self._reports += 1
        self._frame_rates_hz += map(float, frame_rates.split())
        self._rtt_ms += map(float, rtts.split())

    def _attend(self, visible: bool, focused: bool, locked: bool) -> None:
        if self._locked and not locked and self._is_running:
            self._losses += 1
        self._is_told = True
        self._visible, self._focused, self._locked = visible, focused, locked

    def _end_stillness(self) -> None:
        if self._still_ticks >= IDLE_AFTER_S * TICK_HZ:
            self._idle_ticks += self._still_ticks
        self._still_ticks = 0
