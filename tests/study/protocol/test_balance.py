"""Guards the cells: what is counted, what is foreseen, and that newcomers even them out."""

from __future__ import annotations

from hypothesis import assume, given
from hypothesis import strategies as st

from study.protocol.balance import Cell, fill_cells, foresee, spread
from study.protocol.consort import Crowd
from study.protocol.lifecycle import STATUSES, Status
from study.protocol.orders import Slot, all_orders, choose_slot

ORDERS = all_orders(("varil", "arroch", "crmiar"))
CROWDS = st.lists(
    st.builds(
        Crowd,
        st.just("live"),
        st.sampled_from(STATUSES),
        st.none(),
        st.just("trial-1"),
        st.none() | st.integers(0, 5),
        st.integers(1, 60),
    ),
    max_size=15,
)


def person(order_index: int, status: Status) -> Crowd:
    return Crowd("live", status, None, "trial-1", order_index, 1)


def cells_of(held: list[Slot], planned: int | None = None) -> tuple[Cell, ...]:
    """The cells when all who hold a place are under way."""
    return fill_cells([person(slot.order_index, "active") for slot in held], ORDERS, planned)


@given(CROWDS)
def test_everybody_with_an_order_counts_once(crowds: list[Crowd]) -> None:
    """Completed and under way add up; who left, or has no order yet, is in no cell."""
    cells = fill_cells(crowds, ORDERS, None)
    assert [(cell.order_index, cell.order) for cell in cells] == list(enumerate(ORDERS))
    placed = [crowd for crowd in crowds if crowd.order_index is not None]
    assert sum(cell.completed for cell in cells) == sum(
        crowd.number for crowd in placed if crowd.status == "completed"
    )
    assert sum(cell.under_way for cell in cells) == sum(
        crowd.number for crowd in placed if crowd.is_under_way
    )
    assert all(cell.predicted == cell.completed + cell.under_way for cell in cells)


def test_an_order_of_an_earlier_version_is_in_no_cell() -> None:
    assert sum(cell.predicted for cell in fill_cells([person(6, "completed")], ORDERS, None)) == 0


@given(st.integers(1, 100), CROWDS)
def test_targets_reach_the_plan_and_no_further_than_needed(
    planned: int, crowds: list[Crowd]
) -> None:
    cells = fill_cells(crowds, ORDERS, planned)
    targets = [cell.target or 0 for cell in cells]
    assert len(set(targets)) == 1
    assert planned <= sum(targets) < planned + len(ORDERS)
    for cell in cells:
        assert cell.missing == max(0, (cell.target or 0) - cell.predicted)


def test_without_a_plan_nobody_is_missing() -> None:
    assert all((cell.target, cell.missing) == (None, 0) for cell in fill_cells([], ORDERS, None))


@given(st.integers(0, 2**53), st.integers(0, 60))
def test_when_nobody_drops_the_prediction_differs_by_at_most_one(seed: int, people: int) -> None:
    held: list[Slot] = []
    for draw in range(people):
        held.append(choose_slot(held, len(ORDERS), seed, draw))
        assert spread(cells_of(held)) <= 1
    assert spread(cells_of(held)) == (people % len(ORDERS) > 0)


@given(st.integers(0, 2**53), st.integers(1, 40), st.data())
def test_places_of_those_who_left_are_filled_again(
    seed: int, people: int, data: st.DataObject
) -> None:
    """After any drop-outs, as many newcomers as the gaps make the cells even again."""
    held: list[Slot] = []
    for draw in range(people):
        held.append(choose_slot(held, len(ORDERS), seed, draw))
    gone = data.draw(st.sets(st.sampled_from(range(people)), max_size=people))
    held = [slot for k, slot in enumerate(held) if k not in gone]
    before = cells_of(held)
    fullest = max(cell.predicted for cell in before)
    gaps = sum(fullest - cell.predicted for cell in before)
    for draw in range(gaps):
        held.append(choose_slot(held, len(ORDERS), seed, people + draw))
    assert spread(cells_of(held)) == 0


@given(CROWDS, st.integers(0, 5), st.integers(-9, 9), st.integers(-9, 9))
def test_foreseeing_and_undoing_cancel(
    crowds: list[Crowd], order: int, completed: int, under_way: int
) -> None:
    """What can happen to a cell can be undone, and no other cell is touched."""
    cells = fill_cells(crowds, ORDERS, 24)
    assume(cells[order].completed + completed >= 0 and cells[order].under_way + under_way >= 0)
    then = foresee(cells, order, completed=completed, under_way=under_way)
    assert then[order].completed == cells[order].completed + completed
    assert then[order].under_way == cells[order].under_way + under_way
    assert [c for c in then if c.order_index != order] == [
        c for c in cells if c.order_index != order
    ]
    assert foresee(then, order, completed=-completed, under_way=-under_way) == cells


def test_no_cell_is_foreseen_below_nothing() -> None:
    then = foresee(fill_cells([], ORDERS, None), 2, completed=-1, under_way=-3)
    assert (then[2].completed, then[2].under_way) == (0, 0)


def test_the_spread_is_of_the_prediction() -> None:
    """One who completed and one under way weigh the same; nothing has no spread."""
    cells = fill_cells(
        [person(0, "completed"), person(0, "paused"), person(1, "joined")], ORDERS, None
    )
    assert spread(cells) == 2
    assert spread([]) == 0
