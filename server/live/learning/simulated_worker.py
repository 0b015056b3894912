"""A worker for learning runs without a person: the believer, as the participant of its trial.

Importing this module loads numba; the server does so after it answers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from server.live.wire import Input
from study.learning.policy_up import stream_seed
from study.people.worker import Believer

if TYPE_CHECKING:
    from study.ar.elements import Display
    from study.warehouse.world import World


class SimulatedWorker:
    """A Sink that hears nothing, and one input frame a tick made from what is displayed.

    Call `next_frame` exactly once before each tick of the trial, those that are re-simulated
    included: then it remembers what it would have seen.
    """

    def __init__(self, world: World, seed: int, last_seq: int = 0) -> None:
        self._believer = Believer(world, stream_seed(seed, "worker"))
        self._seq = last_seq

    def next_frame(self, display: Display) -> tuple[int, int]:
        """Keys and yaw for the coming tick."""
        return self._believer.next_frame(display)

    def next_input(self, display: Display) -> Input:
        """The same as a message to the room."""
        self._seq += 1
        return Input(self._seq, (self.next_frame(display),))

    def send_text(self, text: str) -> None:
        """It does not read."""

    def send_control(self, data: bytes) -> None:
        """It looks at the display itself."""

    def send_snapshot(self, data: bytes) -> None:
        """It looks at the world itself."""

    def send_finished(self) -> None:
        """It goes nowhere; the next trial has a worker of its own."""

    def close(self, code: int, reason: str) -> None:
        """There is no line to close."""
