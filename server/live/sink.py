"""Whoever listens to a room: what it can be told. None of this ever waits."""

from __future__ import annotations

from typing import Protocol


class Sink(Protocol):
    """One listener. Control messages arrive all and in order; of snapshots only the newest."""

    def send_text(self, text: str) -> None:
        """Queue a text message."""
        ...

    def send_control(self, data: bytes) -> None:
        """Queue a binary message that must not be lost (plans, display)."""
        ...

    def send_snapshot(self, data: bytes) -> None:
        """Offer the newest snapshot; one that was not yet sent is replaced."""
        ...

    def send_finished(self) -> None:
        """The trial is over and stored: tell where to go now."""
        ...

    def close(self, code: int, reason: str) -> None:
        """End the listening after what is queued has been sent."""
        ...
