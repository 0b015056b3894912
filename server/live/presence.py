"""Whether the participant is there: their socket, their page, and their hands."""

from __future__ import annotations

from typing import Literal

from server.live.clock import Clock
from server.live.wire import SILENT_AFTER_S

PAUSE_AFTER_SILENCE_S = 5.0
CLOSE_AFTER_SILENCE_S = 120.0


class Presence:
    """Times since the participant was last connected, heard and seen to send input.

    `is_page_shown` is what the page last said of itself; a hidden page sends no input and does
    not resume a paused world by itself.
    """

    def __init__(self, clock: Clock) -> None:
        self.is_connected = False
        self.is_page_shown = True
        self._clock = clock
        self._changed_s = self._heard_s = self._input_s = clock.now_s()
        self._is_silent = False

    def arrive(self) -> None:
        """A socket joined."""
        self.is_connected, self.is_page_shown = True, True
        self._changed_s = self._heard_s = self._input_s = self._clock.now_s()

    def leave(self) -> None:
        """The socket is gone."""
        self.is_connected = False
        self._changed_s = self._clock.now_s()

    def hear(self) -> None:
        """Any message came."""
        self._heard_s = self._clock.now_s()

    def hear_input(self) -> float | None:
        """Input came; returns how long it had been silent, if it was."""
        self._heard_s = self._clock.now_s()
        silent_s = self._heard_s - self._input_s
        self._input_s = self._heard_s
        was_silent, self._is_silent = self._is_silent, False
        return silent_s if was_silent else None

    def expect_input(self) -> None:
        """The world starts to run: silence counts from now."""
        self._input_s = self._clock.now_s()
        self._is_silent = False

    def check_input(self) -> Literal["", "silent", "too long"]:
        """“silent” once when 250 ms passed without input; “too long” after 5 s."""
        silent_s = self._clock.now_s() - self._input_s
        if silent_s > PAUSE_AFTER_SILENCE_S:
            return "too long"
        if silent_s > SILENT_AFTER_S and not self._is_silent:
            self._is_silent = True
            return "silent"
        return ""

    def is_mute(self) -> bool:
        """Connected, but not a word for two minutes."""
        return self.is_connected and self._clock.now_s() - self._heard_s > CLOSE_AFTER_SILENCE_S

    def absent_s(self) -> float:
        """How long nobody has been connected."""
        return 0.0 if self.is_connected else self._clock.now_s() - self._changed_s

    def backdate_absence(self, absent_s: float) -> None:
        """Nobody had been there for so long already, before the server started."""
        self._changed_s = self._clock.now_s() - absent_s
