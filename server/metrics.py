"""Figures of the running server for Prometheus. None names a participant."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from prometheus_client.core import GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from server.live.hall import Hall


class ServerFigures(Collector):
    """Reads the live loop whenever the figures are asked for."""

    def __init__(self, hall: Hall) -> None:
        self._hall = hall

    def collect(self) -> Iterator[Metric]:
        """Rooms by phase, tick lateness, and how storing goes."""
        rooms = GaugeMetricFamily("varil_rooms", "Trials held in memory.", labels=["phase"])
        for phase, number in Counter(str(room.phase) for room in self._hall.rooms.values()).items():
            rooms.add_metric([phase], number)
        yield rooms
        lateness = GaugeMetricFamily(
            "varil_tick_lateness_seconds", "How late ticks began.", labels=["quantile"]
        )
        for quantile in (0.5, 0.99):
            late_s = self._hall.ticker.lateness.quantile_ms(quantile) / 1000
            lateness.add_metric([str(quantile)], late_s)
        yield lateness
        yield GaugeMetricFamily(
            "varil_ticks_lost_seconds",
            "World time given up because the server could not keep pace.",
            value=self._hall.ticker.lateness.lost_s,
        )
        writer = self._hall.writer
        yield GaugeMetricFamily(
            "varil_commits", "Commits of journals since the start.", value=writer.commits
        )
        yield GaugeMetricFamily(
            "varil_slowest_commit_seconds", "Slowest commit so far.", value=writer.slowest_commit_s
        )
        yield GaugeMetricFamily(
            "varil_storage_failing",
            "1 while journals cannot be stored.",
            value=float(writer.failing_since_s is not None),
        )

    def describe(self) -> Iterator[Metric]:
        """Nothing to ask at registration."""
        return iter(())
