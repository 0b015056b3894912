"""Guards that counting pair by pair gives what looking at the whole dataset gives."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from study.learning.curve import LINES, RATES, Curve
from study.learning.dataset import Dataset, Pair
from study.learning.discrepancies import measure

ITERATIONS = 4
masks = st.integers(0, 7)


@st.composite
def pairs(draw: st.DrawFn) -> Pair:
    domain = draw(st.integers(0, 1))
    cut = 1 if domain else 7
    box, proposal, drawn = (draw(masks) & cut for _ in range(3))
    label = box & drawn | proposal & ~drawn
    j = draw(st.integers(0, ITERATIONS - 1))
    state = draw(st.integers(0, 17))
    return Pair(j, 0, 1, 120, domain, 0, state, box, proposal, drawn, label, -1, by_expert=1)


@given(st.lists(pairs(), max_size=40))
def test_the_running_counts_are_the_final_ones(entries: list[Pair]) -> None:
    curve = Curve(ITERATIONS)
    for entry in entries:
        curve.add(entry)
    found = measure(Dataset(entries), ITERATIONS)
    shown = curve.to_json(1, ITERATIONS)
    for name in LINES:
        for counts in ("compared", "disable", "enable", "shown"):
            mine, whole = getattr(curve.lines[name], counts), getattr(found[name], counts)
            assert mine.tolist() == whole.tolist(), (name, counts)
        assert shown[name]["enable"] == found[name].enable[1:].tolist()
        for rate in RATES:
            wanted = [round(getattr(found[name], rate)(slice(j, j + 1)), 6) for j in range(1, 4)]
            assert shown[name][rate] == wanted
