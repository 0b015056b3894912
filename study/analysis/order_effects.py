"""Order and carry-over: does the position matter, does the condition met before?

Both by F tests of nested least-squares models with participants as fixed effects. Carry-over
follows the crossover design's usual coding: no carry-over at the first position (Jones and
Kenward 2014, chapter 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from study.analysis.descriptives import has_spread
from study.analysis.designs import Design, Untestable, require
from study.analysis.model_matrices import describe_rows, left_over, rank_of, within


@dataclass(frozen=True)
class NestedTest:
    """F test of what a set of columns adds to a model. `scale` is `log` or `raw`."""

    measure: str
    what: str
    scale: str
    n: int
    rows: int
    f: float
    df: int
    df_error: int
    p: float
    partial_eta_squared: float


def check_position(design: Design, *, logarithms: bool) -> NestedTest:
    """Does the position explain anything beside participant and condition?"""
    return _add_columns(design, "position", logarithms)


def check_carry_over(design: Design, *, logarithms: bool) -> NestedTest:
    """Does the previous condition explain anything beside participant, condition, position?"""
    return _add_columns(design, "previous condition", logarithms)


def _add_columns(design: Design, what: str, logarithms: bool) -> NestedTest:
    """Errors: Untestable where the columns cannot be told apart from those of the smaller model."""
    require(design, 2)
    rows = describe_rows(design)
    if logarithms and np.any(rows.values <= 0):
        raise Untestable(f"{design.measure} has values of 0 or less, which have no logarithm")
    y = np.log(rows.values) if logarithms else rows.values
    small = rows.conditions
    added = rows.positions
    if what != "position":
        small, added = np.column_stack([small, rows.positions]), rows.previous
    large = within(rows, np.column_stack([small, added]))
    small = within(rows, small)
    df = rank_of(large) - rank_of(small)
    df_error = len(y) - design.n - rank_of(large)
    if df < 1:
        raise Untestable(f"{what} cannot be told apart from the rest in these orders")
    if df_error < 1:
        raise Untestable(f"too few participants to estimate the effect of {what}")
    own = within(rows, y[:, np.newaxis])[:, 0]
    left_small, left_large = left_over(small, own), left_over(large, own)
    if not has_spread(left_large, y):
        raise Untestable("nothing varies within participants beyond condition and position")
    error = float(left_large @ left_large)
    gain = max(0.0, float(left_small @ left_small) - error)
    f = (gain / df) / (error / df_error)
    return NestedTest(
        measure=design.measure,
        what=what,
        scale="log" if logarithms else "raw",
        n=design.n,
        rows=len(y),
        f=f,
        df=df,
        df_error=df_error,
        p=float(stats.f.sf(f, df, df_error)),
        partial_eta_squared=gain / (gain + error),
    )
