"""Design matrices of within-participant models: who, under which condition, at which position."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from study.analysis.designs import Design, Floats


@dataclass(frozen=True)
class ModelRows:
    """A design's readings as matrices of zeros and ones, a row per reading.

    `participants` are indices; `conditions` and `positions` lack their first level, which the
    others are compared with. `previous` marks the condition of the participant's reading
    before this one, a column per condition, zero for the first.
    """

    values: Floats
    participants: npt.NDArray[np.int64]
    conditions: Floats
    condition_names: tuple[str, ...]
    positions: Floats
    position_names: tuple[str, ...]
    previous: Floats
    previous_names: tuple[str, ...]


def describe_rows(design: Design) -> ModelRows:
    """The matrices of a design; names are `arroch`, `position 2` and `after arroch`."""
    readings = sorted(design.readings, key=lambda one: (one.participant, one.position))
    places = sorted({reading.position for reading in readings})
    before: list[str] = [
        last.condition if last is not None and last.participant == this.participant else ""
        for last, this in zip([None, *readings[:-1]], readings, strict=True)
    ]
    who = {code: place for place, code in enumerate(sorted(design.participants))}
    met = [name for name in design.conditions if name in before]
    return ModelRows(
        values=np.array([reading.value for reading in readings], np.float64),
        participants=np.array([who[one.participant] for one in readings], np.int64),
        conditions=_mark([one.condition for one in readings], list(design.conditions[1:])),
        condition_names=design.conditions[1:],
        positions=_mark([one.position for one in readings], places[1:]),
        position_names=tuple(f"position {place}" for place in places[1:]),
        previous=_mark(before, met),
        previous_names=tuple(f"after {name}" for name in met),
    )


def within(rows: ModelRows, matrix: Floats) -> Floats:
    """The matrix's columns as deviations from each participant's own mean.

    Least squares on them equal those with a column per participant (Frisch, Waugh and Lovell),
    whose rank is greater by the number of participants.
    """
    people = int(rows.participants.max()) + 1
    sums = np.zeros((people, matrix.shape[1]))
    np.add.at(sums, rows.participants, matrix)
    sizes = np.bincount(rows.participants, minlength=people)
    return np.asarray(matrix - (sums / sizes[:, np.newaxis])[rows.participants], np.float64)


def left_over(matrix: Floats, y: Floats) -> Floats:
    """What least squares of y on the matrix's columns leave."""
    if not matrix.shape[1]:
        return y
    solution = np.linalg.lstsq(matrix, y, rcond=None)[0]
    return np.asarray(y - matrix @ solution, np.float64)


def rank_of(matrix: Floats) -> int:
    """Number of independent columns."""
    return int(np.linalg.matrix_rank(matrix)) if matrix.size else 0


def _mark(values: Sequence[object], levels: Sequence[object]) -> Floats:
    marks = [[float(value == level) for level in levels] for value in values]
    return np.array(marks, np.float64).reshape(len(values), len(levels))
