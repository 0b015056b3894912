"""The input frames a client has sent and the world has not yet consumed.

One frame is 1/30 s of the human's motion. A tick takes one frame, up to three while more than two
wait, and never more in total than the elapsed ticks plus eight: sending faster moves nobody
faster. What exceeds that is taken over without effect, so that its sender is not left behind for
good, and counted.
"""

from __future__ import annotations

from collections import deque

from server.live.wire import Input, WireError

Frame = tuple[int, int]

MAX_PER_TICK = 3
KEEP_WAITING = 2
HEAD_START_FRAMES = 8
MAX_WAITING = 90
MAX_GAP = 100_000


class Inbox:
    """The queue of one participant's input frames.

    `acknowledged_seq` is the number of the last frame that was consumed or discarded; `consumed`
    counts all consumed frames of the trial; `discarded` those without effect since last asked.
    """

    def __init__(self, acknowledged_seq: int = 0, consumed: int = 0) -> None:
        self.acknowledged_seq = acknowledged_seq
        self.consumed = consumed
        self.discarded = 0
        self._received_seq = acknowledged_seq
        self._waiting: deque[tuple[int, Frame]] = deque()

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, message: Input) -> None:
        """Queue what is new in a message; frames sent twice count once."""
        seq = message.first_seq
        if seq - self._received_seq > MAX_GAP:
            raise WireError(f"frames from {self._received_seq + 1}", f"frame {seq}")
        for frame in message.frames:
            if seq > self._received_seq:
                self._waiting.append((seq, frame))
                self._received_seq = seq
            seq += 1
        if len(self._waiting) > MAX_WAITING:
            self._discard(MAX_WAITING)

    def take(self, elapsed_ticks: int) -> tuple[Frame, ...]:
        """The frames for the tick that is the `elapsed_ticks`-th of the trial."""
        waiting = self._waiting
        if not waiting:
            return ()
        allowed = elapsed_ticks + HEAD_START_FRAMES - self.consumed
        if len(waiting) <= KEEP_WAITING + 1 and allowed > 0:
            self.acknowledged_seq, frame = waiting.popleft()
            self.consumed += 1
            return (frame,)
        taken: list[Frame] = []
        while len(taken) < min(MAX_PER_TICK, allowed) and (len(waiting) > KEEP_WAITING):
            self.acknowledged_seq, frame = waiting.popleft()
            taken.append(frame)
        self.consumed += len(taken)
        if allowed <= MAX_PER_TICK:
            self._discard(HEAD_START_FRAMES)
        return tuple(taken)

    def clear(self) -> None:
        """Forget waiting frames without acknowledging them: the world stopped."""
        self._waiting.clear()
        self._received_seq = self.acknowledged_seq

    def _discard(self, keep: int) -> None:
        while len(self._waiting) > keep:
            self.acknowledged_seq, _ = self._waiting.popleft()
            self.discarded += 1
