"""Worked examples from the literature, as data; each says where it was printed."""

from __future__ import annotations

import numpy as np

from study.analysis.designs import Design, Reading, complete_cases


def make_design(table: list[list[float]], names: tuple[str, ...], measure: str = "value") -> Design:
    """A design whose readings stand in the order of the columns."""
    people = [f"P{row:03}" for row in range(len(table))]
    readings = [
        Reading(person, name, position, value)
        for person, row in zip(people, table, strict=True)
        for position, (name, value) in enumerate(zip(names, row, strict=True), 1)
    ]
    return complete_cases(measure, readings, names, people, {})


# Field, Discovering Statistics Using SPSS, repeated-measures chapter (“I'm a celebrity ...”):
# seconds until eight celebrities retch at four animals.
BUSHTUCKER = make_design(
    [
        [8, 7, 1, 6],
        [9, 5, 2, 5],
        [6, 2, 3, 8],
        [5, 3, 1, 9],
        [8, 4, 5, 8],
        [7, 5, 6, 7],
        [10, 2, 7, 2],
        [12, 6, 8, 1],
    ],
    ("stick insect", "kangaroo", "fish eye", "grub"),
)
# Pinheiro and Bates, Mixed-Effects Models in S and S-PLUS (2000), section 1.2; `nlme::ergoStool`:
# effort of nine people to rise from four stools.
STOOLS = make_design(
    [
        [12, 15, 12, 10],
        [10, 14, 13, 12],
        [7, 14, 13, 9],
        [7, 11, 10, 9],
        [8, 11, 8, 7],
        [9, 11, 11, 10],
        [8, 12, 12, 11],
        [7, 11, 8, 7],
        [9, 13, 10, 8],
    ],
    ("T1", "T2", "T3", "T4"),
)
# Hollander and Wolfe, Nonparametric Statistical Methods, section 7.1; `?friedman.test` of R:
# seconds of 22 baseball players with three ways of rounding first base.
ROUNDING = make_design(
    [
        [5.40, 5.50, 5.55], [5.85, 5.70, 5.75], [5.20, 5.60, 5.50], [5.55, 5.50, 5.40],
        [5.90, 5.85, 5.70], [5.45, 5.55, 5.60], [5.40, 5.40, 5.35], [5.45, 5.50, 5.35],
        [5.25, 5.15, 5.00], [5.85, 5.80, 5.70], [5.25, 5.20, 5.10], [5.65, 5.55, 5.45],
        [5.60, 5.35, 5.45], [5.05, 5.00, 4.95], [5.50, 5.50, 5.40], [5.45, 5.55, 5.50],
        [5.55, 5.55, 5.35], [5.45, 5.50, 5.55], [5.50, 5.45, 5.25], [5.65, 5.60, 5.40],
        [5.70, 5.65, 5.55], [6.30, 6.30, 6.25],
    ],
    ("round out", "narrow angle", "wide angle"),
)  # fmt: skip
# Hollander and Wolfe, section 3.1; `?wilcox.test` of R: depression of nine patients before and
# after the first session of therapy.
DEPRESSION = np.array([1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30]) - np.array(
    [0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29]
)
# Student, Biometrika 6 (1908); `?sleep` of R: hours of sleep gained with two drugs.
SLEEP = make_design(
    [
        [0.7, 1.9], [-1.6, 0.8], [-0.2, 1.1], [-1.2, 0.1], [-0.1, -0.1],
        [3.4, 4.4], [3.7, 5.5], [0.8, 1.6], [0.0, 4.6], [2.0, 3.4],
    ],
    ("drug 1", "drug 2"),
)  # fmt: skip
