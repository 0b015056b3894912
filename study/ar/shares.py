"""For how much of the time each element was on, and how often another display would differ."""

from __future__ import annotations

from collections import Counter

from study.ar.elements import Display, Element, Overlay

ELEMENTS = tuple((element.name or "").lower() for element in Element)
OVERLAYS = tuple((overlay.name or "").lower() for overlay in Overlay)


class DisplayShares:
    """Counts ticks; a share is over all robots, all stations, or of the overlays over time."""

    def __init__(self, robots: int, stations: int) -> None:
        self._totals = dict.fromkeys(ELEMENTS, robots) | {"balloon": stations}
        self._totals |= dict.fromkeys(OVERLAYS, 1)
        self._counts: Counter[str] = Counter()
        self._ticks = 0
        self._has_other = False
        self._held: tuple[Display, Display | None] | None = None
        self._held_ticks = 0

    def add(self, shown: Display, other: Display | None = None) -> None:
        """One more tick with this display, and what another would have shown in its place."""
        if self._held is None or self._held[0] is not shown or self._held[1] is not other:
            self._settle()
            self._held = (shown, other)
        self._held_ticks += 1

    def summary(self) -> dict[str, float]:
        """Shares from 0 to 1, as `shown_trajectory`; with another display `policy_`, `differs_`."""
        self._settle()
        kinds = ("shown", "policy", "differs") if self._has_other else ("shown",)
        return {
            f"{kind}_{name}": round(self._counts[f"{kind}_{name}"] / (self._ticks * per), 4)
            for kind in kinds
            for name, per in self._totals.items()
            if self._ticks and per
        }

    def _settle(self) -> None:
        """Count the display held until now with its ticks."""
        ticks, self._held_ticks = self._held_ticks, 0
        if self._held is None or ticks == 0:
            return
        shown, other = self._held
        self._ticks += ticks
        self._count("shown", shown, ticks)
        if other is not None:
            self._has_other = True
            self._count("policy", other, ticks)
            self._count("differs", _difference(shown, other), ticks)

    def _count(self, kind: str, display: Display, ticks: int) -> None:
        for bit, name in enumerate(ELEMENTS):
            self._counts[f"{kind}_{name}"] += ticks * sum(m >> bit & 1 for m in display.robots)
        self._counts[f"{kind}_balloon"] += ticks * sum(map(bool, display.stations))
        for bit, name in enumerate(OVERLAYS):
            self._counts[f"{kind}_{name}"] += ticks * (display.overlays >> bit & 1)


def _difference(one: Display, other: Display) -> Display:
    robots = bytes(a ^ b for a, b in zip(one.robots, other.robots, strict=True))
    stations = bytes(a ^ b for a, b in zip(one.stations, other.stations, strict=True))
    return Display(robots, stations, one.overlays ^ other.overlays)
