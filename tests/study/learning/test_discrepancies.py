"""Guards the discrepancies against counts made by hand."""

from __future__ import annotations

from study.learning.dataset import Dataset, Pair
from study.learning.discrepancies import measure


def pair(iteration: int, domain: int, state: int, box: int, proposal: int, drawn: int) -> Pair:
    label = box & drawn | proposal & ~drawn
    return Pair(
        iteration, 0, 1, 120, domain, 0, state, box, proposal, drawn, label, -1, by_expert=0
    )


def test_counts_by_hand() -> None:
    dataset = Dataset()
    for entry in (
        pair(0, 0, 3, box=0b001, proposal=0b111, drawn=7),  # two to disable
        pair(0, 0, 3, box=0b000, proposal=0b111, drawn=1),  # one compared, one to disable
        pair(0, 1, 2, box=1, proposal=0, drawn=1),  # one to enable
        pair(1, 1, 2, box=0, proposal=1, drawn=0),  # nothing to compare
        pair(2, 0, 3, box=0b101, proposal=0b011, drawn=7),
    ):
        dataset.add(entry)
    found = measure(dataset, 4)
    own = found["policy"]
    assert own.compared.tolist() == [5, 0, 3, 0]
    assert own.disable.tolist() == [3, 0, 1, 0]
    assert own.enable.tolist() == [1, 0, 1, 0]
    assert own.shown.tolist() == [4, 0, 2, 0]
    assert own.off_rate() == 4 / 8
    assert own.hamming_rate() == 6 / 8
    assert own.shown_share(slice(2, 3)) == 2 / 3
    assert own.hamming_rate(slice(1, 2)) == 0.0
    assert found["arroch"].disable.tolist() == [3, 0, 1, 0]
    assert found["arroch"].enable.tolist() == [1, 0, 0, 0]
    assert found["all_off"].disable.tolist() == [0, 0, 0, 0]
    assert found["all_off"].enable.tolist() == [2, 0, 2, 0]
    assert found["floor"].hamming_rate() == 2 / 8  # live location off once, trajectory on once
    assert found["majority"].hamming_rate() == 2 / 8


def test_no_line_undercuts_the_floor() -> None:
    """The floor is the best table in hindsight, so a constant one cannot beat it."""
    dataset = Dataset()
    for n in range(400):
        state = n * 7 % 11
        dataset.add(pair(n // 25, 0, state, (state * 3 + n // 90) % 8, n % 8, 7 if n % 3 else 1))
    found = measure(dataset, 16)
    floor = found.pop("floor") if isinstance(found, dict) else found["floor"]
    assert all(floor.hamming_rate() <= line.hamming_rate() for line in found.values())
    assert 0 < floor.hamming_rate() < found["majority"].hamming_rate()
