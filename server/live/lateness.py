"""How late ticks came, as a histogram."""

from __future__ import annotations

BUCKET_MS = 0.25
BUCKETS = 400


class Lateness:
    """How late ticks were: a histogram in steps of 0.25 ms up to 100 ms, and what lies beyond."""

    def __init__(self) -> None:
        self.counts = [0] * (BUCKETS + 1)
        self.worst_s = 0.0
        self.lost_s = 0.0

    def add(self, late_s: float, ticks: int = 1) -> None:
        """Count `ticks` that were `late_s` late."""
        bucket = int(late_s * (1000.0 / BUCKET_MS)) if late_s > 0 else 0
        self.counts[min(bucket, BUCKETS)] += ticks
        self.worst_s = max(self.worst_s, late_s)

    @property
    def total(self) -> int:
        """Ticks counted."""
        return sum(self.counts)

    def quantile_ms(self, share: float) -> float:
        """The lateness that `share` of the ticks did not exceed (upper border of its bucket)."""
        wanted = share * self.total
        seen = 0
        for bucket, count in enumerate(self.counts):
            seen += count
            if count and seen >= wanted:
                return (bucket + 1) * BUCKET_MS if bucket < BUCKETS else self.worst_s * 1000.0
        return 0.0
