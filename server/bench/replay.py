"""How long it takes to re-simulate five minutes of a trial from its journal, at `study` scale."""

from __future__ import annotations

import time
from collections import deque
from statistics import median
from typing import Any

from server.bench.wire import record_walk
from study.records.journal import HASH_EVERY_TICKS, JournalChunk, JournalRecorder, encode_frames
from study.records.journal import replay as replay_journal
from study.warehouse.halls import PRESETS, TICK_HZ
from study.warehouse.layout import build_layout
from study.warehouse.world import World

MINUTES = 5
SEED = 1


def measure_replay(repeats: int = 5) -> dict[str, Any]:
    """Seconds per re-simulation with every hash compared: the median and all of them."""
    chunks = record_journal()
    layout, seconds = build_layout(PRESETS["study"]), []
    for _ in range(repeats):
        started_s = time.perf_counter()
        deque(replay_journal(World(layout, SEED), chunks), maxlen=0)
        seconds.append(round(time.perf_counter() - started_s, 4))
    return {"ticks": sum(c.ticks for c in chunks), "median_s": median(seconds), "all_s": seconds}


def record_journal() -> list[JournalChunk]:
    """A simulated worker's first five minutes, in one chunk per second as the server stores it."""
    world, recorder = World(build_layout(PRESETS["study"]), SEED), JournalRecorder()
    chunks = []
    for frame in record_walk(SEED)[: MINUTES * 60 * TICK_HZ]:
        world.step((frame,))
        recorder.add_tick(encode_frames((frame,)))
        if world.tick % HASH_EVERY_TICKS == 0:
            recorder.add_hash(world.tick, world.state_hash())
            chunk = recorder.take_chunk()
            if chunk is not None:
                chunks.append(chunk)
    return chunks
