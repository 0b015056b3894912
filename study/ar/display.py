"""When the display may change: decisions once a second, no element flickers [our choice]."""

from __future__ import annotations

from typing import Protocol

from study.ar.conditions import Condition
from study.ar.elements import Display
from study.ar.situation import ObservedWorld

DECISION_EVERY_TICKS = 30
HOLD_TICKS = 60
BITS = 4


class DisplaySource(Protocol):
    """Whatever decides over a trial what is visible."""

    @property
    def display(self) -> Display:
        """What is visible now."""
        ...

    def update(self, world: ObservedWorld) -> Display | None:
        """Called after every tick; the new display if it changed."""
        ...


class DisplayClock:
    """Asks a condition every 30th tick and holds each element for at least 60 ticks (2 s).

    Its state follows from the world's states alone, so a re-simulation that calls `update` after
    every tick arrives at the same display.
    """

    def __init__(self, condition: Condition, robots: int, stations: int) -> None:
        self.condition = condition
        self.display = Display.nothing(robots, stations)
        self._since = [[-HOLD_TICKS] * BITS for _ in range(robots + stations + 1)]

    def start(self, world: ObservedWorld) -> Display:
        """The first decision, before the first tick; nothing has to be held yet."""
        self.display = self.condition.decide(world, self.display)
        self._since = [[world.tick] * BITS for _ in self._since]
        return self.display

    def update(self, world: ObservedWorld) -> Display | None:
        """The new display if this tick brings a decision that changes something."""
        if world.tick % DECISION_EVERY_TICKS:
            return None
        wished = self.condition.decide(world, self.display)
        if wished == self.display:
            return None
        held = self._hold(wished, world.tick)
        if held == self.display:
            return None
        self.display = held
        return held

    def _hold(self, wished: Display, tick: int) -> Display:
        shown = (*self.display.robots, *self.display.stations, self.display.overlays)
        wanted = (*wished.robots, *wished.stations, wished.overlays)
        masks = [
            old if old == new else self._hold_mask(index, old, new, tick)
            for index, (old, new) in enumerate(zip(shown, wanted, strict=True))
        ]
        robots = len(self.display.robots)
        return Display(bytes(masks[:robots]), bytes(masks[robots:-1]), masks[-1])

    def _hold_mask(self, index: int, old: int, new: int, tick: int) -> int:
        since = self._since[index]
        for bit in range(BITS):
            if (old ^ new) >> bit & 1 and tick - since[bit] >= HOLD_TICKS:
                since[bit] = tick
                old ^= 1 << bit
        return old
