"""The trial of a simulated participant: its inputs drive the world, not the clock.

Each input message advances the world by the frames it carries, one tick each, and is answered by
one snapshot. Everything else is the room's own: inbox, steps, journal, decisions, phases, storage.
The ticker only looks whether the participant is still there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from server.live import wire
from server.live.room import Room
from study.errors import NotAllowedLive

if TYPE_CHECKING:
    from server.live.ports import TrialSetup

BOT = "bot"


class LockStepRoom(Room):
    """A room without time of its own. Raises `NotAllowedLive` for a trial of anybody but a bot."""

    def __init__(self, setup: TrialSetup, *parts: Any) -> None:
        if setup.mode != BOT:
            raise NotAllowedLive("lock-step")
        super().__init__(setup, *parts)

    def take_input(self, message: wire.Input) -> None:
        """Advance by one tick for each new frame; WireError when they come too early."""
        if self.phase != "running":
            super().take_input(message)
            return
        self._presence.hear_input()
        for number, frame in enumerate(message.frames):
            self._inbox.put(wire.Input(message.first_seq + number, (frame,)))
            if len(self._inbox) and self.phase == "running":
                self.step()
        self._audience.send_snapshot(self._inbox.acknowledged_seq)

    def advance(self) -> None:
        """No tick; one who is silent or gone for too long is given up as anybody."""
        if self.phase != "finished":
            self._check_absence()

    def note_lag(self, lost_s: float) -> None:
        """The world waits for its participant, so the server is never late for it."""

    def note_late(self, late_s: float) -> None:
        """As with lags."""

    def _go_on(self) -> None:
        """There is nobody to count down for."""
        super()._go_on()
        if self.phase == "countdown":
            self._start_running()

    def _stop_running(self) -> None:
        """Nothing goes on without inputs, whatever the study says of live participants."""
        if self.phase == "running":
            self._pause("disconnected")
        else:
            super()._stop_running()
