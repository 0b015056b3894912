"""How evenly the orders of a study are filled, now and if those under way finish."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from study.protocol.consort import Crowd


@dataclass(frozen=True)
class Cell:
    """One order of the conditions: who completed it and who is under way in it.

    `target`: how many completed ones the plan asks for, None without a plan.
    """

    order_index: int
    order: tuple[str, ...]
    completed: int
    under_way: int
    target: int | None

    @property
    def predicted(self) -> int:
        """How many will have completed if everybody under way does."""
        return self.completed + self.under_way

    @property
    def missing(self) -> int:
        """How many are still to be recruited for this order."""
        return max(0, (self.target or 0) - self.predicted)


def fill_cells(
    crowds: Iterable[Crowd], orders: Sequence[Sequence[str]], planned: int | None
) -> tuple[Cell, ...]:
    """The cells of a study; `planned` participants are spread over the orders, rounded up.

    Who has no order yet, or one that the present version of the study lacks, is in no cell.
    """
    completed, under_way = [0] * len(orders), [0] * len(orders)
    for crowd in crowds:
        if crowd.order_index is None or crowd.order_index >= len(orders):
            continue
        if crowd.status == "completed":
            completed[crowd.order_index] += crowd.number
        elif crowd.is_under_way:
            under_way[crowd.order_index] += crowd.number
    target = None if planned is None else -(-planned // len(orders))
    return tuple(
        Cell(k, tuple(order), completed[k], under_way[k], target) for k, order in enumerate(orders)
    )


def spread(cells: Iterable[Cell]) -> int:
    """How many more the fullest order will have than the emptiest, if those under way finish."""
    numbers = [cell.predicted for cell in cells]
    return max(numbers) - min(numbers) if numbers else 0


def foresee(
    cells: Sequence[Cell], order_index: int, *, completed: int, under_way: int
) -> tuple[Cell, ...]:
    """The cells after one of them gained (or, below 0, lost) so many; none falls below 0."""
    return tuple(
        replace(
            cell,
            completed=max(0, cell.completed + completed),
            under_way=max(0, cell.under_way + under_way),
        )
        if cell.order_index == order_index
        else cell
        for cell in cells
    )
