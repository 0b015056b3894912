"""The two clocks the live loop is handed: one to measure with, one to write down."""

from __future__ import annotations

import time
from datetime import UTC, datetime
from typing import Protocol


class Clock(Protocol):
    """Where time comes from; tests bring their own."""

    def now_s(self) -> float:
        """Seconds that never go backwards, from any start."""
        ...

    def utc(self) -> datetime:
        """The time of day, aware, in UTC."""
        ...


class SystemClock:
    """The machine's clocks."""

    def now_s(self) -> float:
        """Monotonic seconds."""
        return time.perf_counter()

    def utc(self) -> datetime:
        """The time of day in UTC."""
        return datetime.now(UTC)
