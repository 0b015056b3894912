"""The journal: what each tick consumed, compactly, and the exact replay made from it.

Encoding of a chunk's inputs, tick after tick: one count byte c (0 to 3), then c frames of three
bytes each: key bits (u8) and yaw (u16, little endian). A tick in which the human's client was
silent costs one byte. State hashes are kept every 30 ticks (one second of world time) and at the
trial's last tick. World + configuration + seed + journal give every state bit again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

from study.errors import JournalError

HASH_EVERY_TICKS = 30
MAX_FRAMES_PER_TICK = 3
FRAME_BYTES = 3

Frames = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class JournalChunk:
    """The inputs of `ticks` successive ticks, the first of which led to tick `first_tick`.

    The world's tick is 0 before any step, so the first chunk has `first_tick` 1. `hashes` holds
    (tick, 8 bytes of state hash) pairs within the chunk. `last_seq` is the number of the last
    input frame taken over.
    """

    first_tick: int
    ticks: int
    inputs: bytes
    hashes: tuple[tuple[int, bytes], ...] = ()
    last_seq: int = 0

    @property
    def last_tick(self) -> int:
        """The tick that the chunk's last step led to."""
        return self.first_tick + self.ticks - 1


class SteppedWorld(Protocol):
    """What a replay needs of a world."""

    @property
    def tick(self) -> int:
        """Ticks stepped so far."""
        ...

    def step(self, frames: Sequence[tuple[int, int]]) -> object:
        """Advance by one tick with these input frames."""
        ...

    def state_hash(self) -> bytes:
        """Eight bytes over every state bit."""
        ...


W = TypeVar("W", bound=SteppedWorld)


def encode_frames(frames: Iterable[tuple[int, int]]) -> bytes:
    """One tick's (keys, yaw) frames as journal bytes."""
    packed = bytearray(1)
    for keys, yaw in frames:
        packed += bytes((keys, yaw & 255, yaw >> 8))
        packed[0] += 1
    return bytes(packed)


def decode_ticks(chunk: JournalChunk) -> Iterator[Frames]:
    """The frames consumed by each tick of a chunk; JournalError if the bytes do not fit."""
    data, at = chunk.inputs, 0
    for tick in range(chunk.first_tick, chunk.first_tick + chunk.ticks):
        count = data[at] if at < len(data) else -1
        end = at + 1 + count * FRAME_BYTES
        if not 0 <= count <= MAX_FRAMES_PER_TICK or end > len(data):
            raise JournalError(
                "the stored inputs are damaged",
                where=f"tick {tick}",
                next_step="Restore this trial from a backup; later ticks cannot be replayed.",
            )
        yield tuple(
            (data[k], data[k + 1] | data[k + 2] << 8) for k in range(at + 1, end, FRAME_BYTES)
        )
        at = end
    if at != len(data):
        raise JournalError(
            f"the chunk holds {len(data) - at} bytes more than its {chunk.ticks} ticks",
            where=f"tick {chunk.last_tick}",
            next_step="Restore this trial from a backup.",
        )


class JournalRecorder:
    """Gathers ticks until they are taken as a chunk. Cheap per tick: it appends a few bytes."""

    def __init__(self, next_tick: int = 1, last_seq: int = 0) -> None:
        self.last_seq = last_seq
        self._first_tick = next_tick
        self._ticks = 0
        self._inputs = bytearray()
        self._hashes: list[tuple[int, bytes]] = []

    def add_tick(self, packed: bytes) -> None:
        """Note the consumed frames of one tick, already as journal bytes."""
        self._inputs += packed
        self._ticks += 1

    def add_hash(self, tick: int, state_hash: bytes) -> None:
        """Note the world's state hash after `tick`."""
        self._hashes.append((tick, state_hash))

    def take_chunk(self) -> JournalChunk | None:
        """Everything since the last call, or None when no tick passed."""
        if self._ticks == 0:
            return None
        chunk = JournalChunk(
            self._first_tick, self._ticks, bytes(self._inputs), tuple(self._hashes), self.last_seq
        )
        self._first_tick += self._ticks
        self._ticks = 0
        self._inputs.clear()
        self._hashes.clear()
        return chunk


def check_chunks(chunks: Sequence[JournalChunk]) -> None:
    """Raise JournalError unless the chunks follow each other without gap or overlap."""
    expected = 1
    for chunk in chunks:
        if chunk.first_tick != expected:
            raise JournalError(
                f"a chunk starts at tick {chunk.first_tick}, wanted {expected}",
                next_step="A part of the journal is missing; restore this trial from a backup.",
            )
        expected += chunk.ticks


def replay(
    world: W,
    chunks: Sequence[JournalChunk],
    on_hash: Callable[[int, bool], None] | None = None,
) -> Iterator[W]:
    """Step a fresh `world` through the journal; yields it after every tick.

    Every recorded hash is compared. Without `on_hash` the first difference raises JournalError;
    with it, it is told (tick, equal) and the replay goes on.
    """
    check_chunks(chunks)
    for chunk in chunks:
        recorded = dict(chunk.hashes)
        for frames in decode_ticks(chunk):
            world.step(frames)
            expected = recorded.get(world.tick)
            if expected is not None:
                _compare(world, expected, on_hash)
            yield world


def _compare(
    world: SteppedWorld, expected: bytes, on_hash: Callable[[int, bool], None] | None
) -> None:
    equal = world.state_hash() == expected
    if on_hash is not None:
        on_hash(world.tick, equal)
    elif not equal:
        raise JournalError(
            "the replayed state differs from the recorded one",
            where=f"tick {world.tick}",
            next_step="Replay with the version of the software that recorded the trial.",
        )
