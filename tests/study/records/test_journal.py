"""Guards the journal: its encoding, its order, and the exact replay of what it holds."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.errors import JournalError
from study.headless import simulate_trial
from study.records.events import EVENT_KINDS, check_event
from study.records.journal import (
    JournalChunk,
    JournalRecorder,
    check_chunks,
    decode_ticks,
    encode_frames,
    replay,
)
from study.warehouse.layout import PRESETS, build_layout
from study.warehouse.world import EVENT_DATA, World

FRAME = st.tuples(st.integers(0, 15), st.integers(0, 65535))
TICKS = st.lists(st.lists(FRAME, max_size=3).map(tuple), max_size=60)


@given(TICKS, st.sets(st.integers(0, 60)))
def test_what_goes_in_comes_out(ticks: list[Any], cuts: set[int]) -> None:
    """However the ticks are cut into chunks, each gives its frames again."""
    recorder, chunks = JournalRecorder(), []
    for number, frames in enumerate(ticks):
        if number in cuts:
            chunks.append(recorder.take_chunk())
        recorder.add_tick(encode_frames(frames))
    chunks.append(recorder.take_chunk())
    kept = [chunk for chunk in chunks if chunk is not None]
    check_chunks(kept)
    assert [frames for chunk in kept for frames in decode_ticks(chunk)] == ticks
    assert sum(len(chunk.inputs) for chunk in kept) == len(ticks) + 3 * sum(map(len, ticks))


def test_a_chunk_is_taken_once() -> None:
    recorder = JournalRecorder(next_tick=31, last_seq=7)
    assert recorder.take_chunk() is None
    recorder.add_tick(encode_frames([(1, 300)]))
    recorder.add_hash(31, b"12345678")
    recorder.last_seq = 8
    chunk = JournalChunk(31, 1, b"\x01\x01\x2c\x01", ((31, b"12345678"),), 8)
    assert recorder.take_chunk() == chunk
    assert chunk.last_tick == 31
    assert recorder.take_chunk() is None


@pytest.mark.parametrize(
    ("inputs", "sentence"),
    [
        (b"\x01\x01\x00", "tick 5: the stored inputs are damaged"),
        (b"\x04" + bytes(12), "tick 5: the stored inputs are damaged"),
        (b"", "tick 5: the stored inputs are damaged"),
        (b"\x00", "tick 6: the stored inputs are damaged"),
        (b"\x00\x00\x00", "holds 1 bytes more than its 2 ticks"),
    ],
)
def test_damaged_inputs_are_named_by_their_tick(inputs: bytes, sentence: str) -> None:
    with pytest.raises(JournalError, match=sentence):
        list(decode_ticks(JournalChunk(5, 2, inputs)))


@pytest.mark.parametrize("starts", [(2,), (1, 3), (1, 1)])
def test_gaps_and_overlaps_are_refused(starts: tuple[int, ...]) -> None:
    with pytest.raises(JournalError, match="a chunk starts at tick"):
        check_chunks([JournalChunk(first, 1, b"\x00") for first in starts])


def play(ticks: int) -> tuple[World, list[JournalChunk]]:
    """A world at `small` scale with a wandering human, and its journal in chunks of 45 ticks."""
    world, recorder, chunks = World(build_layout(PRESETS["small"]), 3), JournalRecorder(), []
    draws = np.random.default_rng(4)
    for tick in range(1, ticks + 1):
        count = int(draws.choice([0, 1, 1, 1, 2, 3]))
        frames = [(int(draws.integers(16)), int(draws.integers(65536))) for _ in range(count)]
        world.step(frames)
        recorder.add_tick(encode_frames(frames))
        if tick % 30 == 0:
            recorder.add_hash(tick, world.state_hash())
        if tick % 45 == 0:
            chunk = recorder.take_chunk()
            assert chunk is not None
            chunks.append(chunk)
    return world, chunks


def test_a_replay_reaches_every_state_again() -> None:
    """Each recorded hash is compared, and the last state is the same to the bit."""
    played, chunks = play(900)
    seen: list[tuple[int, bool]] = []
    world = World(build_layout(PRESETS["small"]), 3)
    for _ in replay(world, chunks, lambda tick, equal: seen.append((tick, equal))):
        pass
    assert seen == [(tick, True) for tick in range(30, 901, 30)]
    assert world.state_hash() == played.state_hash()


def test_a_changed_input_is_noticed_within_a_second() -> None:
    """One key more in one tick: the next hash differs and says where."""
    _, chunks = play(450)
    first = chunks[4]
    at = first.inputs.index(1)
    changed = bytearray(first.inputs)
    changed[at + 1] ^= 5
    world = World(build_layout(PRESETS["small"]), 3)
    with pytest.raises(JournalError, match=r"tick (210|240): the replayed state differs"):
        for _ in replay(world, [*chunks[:4], replace(first, inputs=bytes(changed)), *chunks[5:]]):
            pass


def test_a_replay_can_report_instead_of_stopping() -> None:
    _, chunks = play(90)
    wrong = replace(chunks[0], hashes=((30, b"87654321"),))
    seen: list[tuple[int, bool]] = []
    world = World(build_layout(PRESETS["small"]), 3)
    for _ in replay(world, [wrong, chunks[1]], lambda tick, equal: seen.append((tick, equal))):
        pass
    assert seen == [(30, False), (60, True), (90, True)]


def test_the_dictionary_knows_every_event_of_the_world() -> None:
    """Kinds and fields as the world tells them."""
    for kind, fields in EVENT_DATA.items():
        whole = {"trial_completed", "trial_timed_out"}
        wanted = set(fields) if kind in whole else {*fields, "robot"}
        assert {field.name for field in EVENT_KINDS[kind].fields} == wanted, kind


def test_every_kind_is_described() -> None:
    """A data dictionary without words is none."""
    for kind in EVENT_KINDS.values():
        assert kind.meaning
        assert kind.version >= 1
        for field in kind.fields:
            assert field.meaning
            assert (field.unit == "s") == field.name.endswith("_s")


@pytest.mark.parametrize(
    ("kind", "data", "sentence"),
    [
        ("tea_break", {}, "there is no event “tea_break”"),
        ("context", {}, r"has the fields \[\], wanted \['lost'\]"),
        ("context", {"lost": 1}, "the field “lost” of the event “context” is 1, wanted bool"),
        ("lagged", {"lost_s": "1"}, "wanted float"),
    ],
)
def test_events_off_the_dictionary_are_refused(kind: str, data: Any, sentence: str) -> None:
    check_event("context", {"lost": True})
    with pytest.raises(JournalError, match=sentence):
        check_event(kind, data)


def test_headless_trials_leave_a_journal_too() -> None:
    """The inputs a simulated worker made, packed as a journal, replay to its last state."""
    layout = build_layout(PRESETS["practice"])
    trial = simulate_trial(layout, 2, "cyclic", keep_inputs=True)
    assert trial.inputs is not None
    packed = b"".join(encode_frames([(int(k), int(y))]) for k, y in trial.inputs)
    world = World(layout, 2)
    for _ in replay(world, [JournalChunk(1, len(trial.inputs), packed)]):
        pass
    assert world.status == "completed"
    assert world.state_hash() == trial.state_hash
