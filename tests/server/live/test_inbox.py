"""Guards the input rules: nobody walks faster by sending more, nobody is left behind for good."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.live.inbox import Inbox
from server.live.wire import Input, WireError


def frames(first: int, count: int) -> Input:
    return Input(first, tuple((1, (first + k) & 65535) for k in range(count)))


def test_one_frame_a_tick_in_order() -> None:
    inbox = Inbox()
    inbox.put(frames(1, 2))
    assert inbox.take(1) == ((1, 1),)
    assert (inbox.acknowledged_seq, len(inbox)) == (1, 1)
    assert inbox.take(2) == ((1, 2),)
    assert inbox.take(3) == ()


@pytest.mark.parametrize(
    ("waiting", "taken"), [(0, 0), (1, 1), (2, 1), (3, 1), (4, 2), (5, 3), (6, 3), (8, 3)]
)
def test_up_to_three_while_more_than_two_wait(waiting: int, taken: int) -> None:
    """With 3 waiting one is taken and two stay; with 5 three are."""
    inbox = Inbox()
    if waiting:
        inbox.put(frames(1, waiting))
    assert len(inbox.take(1000)) == taken


@given(st.lists(st.tuples(st.integers(0, 8), st.booleans()), max_size=300))
def test_never_more_than_the_elapsed_ticks_plus_eight(steps: list[tuple[int, bool]]) -> None:
    """Whatever is sent, in total and at every moment; order is kept, nothing is consumed twice."""
    inbox, sent, elapsed = Inbox(), 0, 0
    consumed: list[tuple[int, int]] = []
    for count, is_tick in steps:
        if count:
            inbox.put(frames(sent + 1, count))
            sent += count
        if is_tick:
            elapsed += 1
            taken = inbox.take(elapsed)
            assert len(taken) <= 3
            consumed += taken
        assert len(consumed) == inbox.consumed <= elapsed + 8
        assert len(inbox) <= 90
        assert inbox.acknowledged_seq + len(inbox) == sent
    assert [yaw for _, yaw in consumed] == sorted({yaw for _, yaw in consumed})
    assert inbox.consumed + inbox.discarded + len(inbox) == sent


def test_a_sender_at_triple_speed_walks_no_farther() -> None:
    """Ten seconds of 90 frames a second move a person by 308 frames, not by 900."""
    inbox, sent = Inbox(), 0
    for tick in range(1, 301):
        inbox.put(frames(sent + 1, 3))
        sent += 3
        inbox.take(tick)
    assert inbox.consumed == 308
    assert inbox.acknowledged_seq >= sent - 8, "the rest was taken over without effect"


def test_a_stalled_line_catches_up() -> None:
    """One second without frames, then all at once: within 15 ticks all is consumed again."""
    inbox = Inbox()
    for tick in range(1, 31):
        inbox.take(tick)
    for first in range(1, 31, 6):
        inbox.put(frames(first, 6))
    for tick in range(31, 46):
        inbox.put(frames(tick, 1))
        inbox.take(tick)
    assert len(inbox) <= 2
    assert inbox.discarded == 0


def test_frames_sent_twice_count_once() -> None:
    inbox = Inbox(acknowledged_seq=10)
    inbox.put(frames(9, 4))
    inbox.put(frames(11, 2))
    assert [inbox.take(100), inbox.take(101), inbox.take(102)] == [((1, 11),), ((1, 12),), ()]


def test_a_wild_sequence_number_is_refused() -> None:
    with pytest.raises(WireError, match="wanted frames from 1, got frame 4000000000"):
        Inbox().put(frames(4_000_000_000, 1))


def test_a_pause_forgets_what_waits() -> None:
    """Frames that were not consumed are not acknowledged; the client may number on or again."""
    inbox = Inbox()
    inbox.put(frames(1, 5))
    inbox.take(1)
    taken = inbox.acknowledged_seq
    inbox.clear()
    assert inbox.take(2) == ()
    inbox.put(frames(taken + 1, 1))
    assert inbox.take(3) == ((1, taken + 1),)
    inbox.clear()
    inbox.put(frames(50, 1))
    assert inbox.take(4) == ((1, 50),)
