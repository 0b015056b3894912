"""Guards the clock of all rooms: fixed steps, groups, bounded catching up, isolation of faults."""

from dataclasses import dataclass, field

import pytest

from server.live.lateness import Lateness
from server.live.ticker import GROUPS, SLOT_S, Ticked, Ticker

from .stage import FakeClock


@dataclass
class Counter:
    ticks: int = 0
    lost_s: list[float] = field(default_factory=list)
    fails_at: int = -1

    def advance(self) -> None:
        self.ticks += 1
        if self.ticks == self.fails_at:
            raise ZeroDivisionError("a fault in one room")

    def note_late(self, late_s: float) -> None:
        pass

    def note_lag(self, lost_s: float) -> None:
        self.lost_s.append(lost_s)


def make(count: int) -> tuple[FakeClock, Ticker, list[Counter], list[Ticked]]:
    clock, failed = FakeClock(), []
    ticker = Ticker(clock, lambda room, problem: failed.append(room))
    rooms = [Counter() for _ in range(count)]
    for room in rooms:
        ticker.add(room)
    return clock, ticker, rooms, failed


def turn(clock: FakeClock, ticker: Ticker, seconds: float) -> None:
    """Wake the ticker every slot for so long."""
    for _ in range(round(seconds / SLOT_S)):
        clock.pass_s(SLOT_S)
        ticker.run_slot()


def test_thirty_ticks_a_second_for_every_room() -> None:
    clock, ticker, rooms, _ = make(10)
    turn(clock, ticker, 10.0)
    assert {room.ticks for room in rooms} <= {299, 300, 301}


def test_rooms_are_spread_over_the_groups() -> None:
    """Within one slot only a quarter of the rooms tick."""
    clock, ticker, rooms, _ = make(GROUPS * 5)
    ticker.run_slot()
    assert sum(room.ticks for room in rooms) == 5
    turn(clock, ticker, 3 * SLOT_S + 1e-6)
    assert [room.ticks for room in rooms] == [1] * 20


def test_a_short_stall_is_made_up() -> None:
    """0.4 s late: afterwards nobody has fewer ticks than time has passed."""
    clock, ticker, rooms, _ = make(4)
    turn(clock, ticker, 1.0)
    clock.pass_s(0.4)
    for _ in range(60):
        ticker.run_slot()
    assert [room.ticks for room in rooms] == [pytest.approx(42, abs=1)] * 4
    assert ticker.lateness.lost_s == 0.0
    assert rooms[0].lost_s == []


def test_a_long_stall_is_given_up_and_told() -> None:
    """Two seconds late: the world did not run meanwhile, nobody races to catch up."""
    clock, ticker, rooms, _ = make(4)
    turn(clock, ticker, 1.0)
    clock.pass_s(2.0)
    for _ in range(60):
        ticker.run_slot()
    assert rooms[0].ticks <= 32
    assert rooms[0].lost_s == [pytest.approx(2.0, abs=0.01)]
    turn(clock, ticker, 1.0)
    assert rooms[0].ticks == pytest.approx(61, abs=2)


def test_a_late_slot_does_not_shift_the_next() -> None:
    """Deadlines are absolute: with every slot 3 ms late the rate stays."""
    clock, ticker, rooms, _ = make(1)
    ticker.run_slot()
    clock.pass_s(0.003)
    turn(clock, ticker, 10.0)
    assert rooms[0].ticks == pytest.approx(300, abs=1)
    assert ticker.lateness.quantile_ms(0.5) == pytest.approx(3.0, abs=0.3)


def test_a_fault_stays_in_its_room() -> None:
    clock, ticker, rooms, failed = make(5)
    rooms[2].fails_at = 10
    turn(clock, ticker, 2.0)
    assert failed == [rooms[2]]
    assert rooms[2].ticks == 10
    assert all(room.ticks >= 59 for room in rooms if room is not rooms[2])


def test_lateness_is_counted_in_quarter_milliseconds() -> None:
    lateness = Lateness()
    lateness.add(-0.001)
    for late_ms in (0.1, 0.3, 9.9, 5000.0):
        lateness.add(late_ms / 1000)
    assert lateness.total == 5
    assert lateness.quantile_ms(0.4) == 0.25
    assert lateness.quantile_ms(0.6) == 0.5
    assert lateness.quantile_ms(0.8) == 10.0
    assert lateness.quantile_ms(1.0) == 5000.0
    assert Lateness().quantile_ms(0.99) == 0.0
