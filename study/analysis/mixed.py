"""The primary analysis: a linear mixed model of the logarithm of a positive measure.

log(value) on condition and position, both as factors, with a random intercept per participant,
fitted by restricted maximum likelihood. Complete cases are balanced, so contrasts between
conditions are tested by t with the residual degrees of freedom within participants.

Fallback, decided before any data: if the fit fails, does not converge or puts the variance of the
intercepts at zero, participants become fixed effects (ordinary least squares within participants),
which estimates the same contrasts. If position cannot be told apart from condition, as when all
met one order, it is left out and the result says so.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats
from statsmodels.regression.mixed_linear_model import MixedLM

from study.analysis.descriptives import LEVEL, has_spread
from study.analysis.designs import Design, Floats, Pairs, Untestable, require
from study.analysis.holm import adjust_holm
from study.analysis.model_matrices import ModelRows, describe_rows, left_over, rank_of, within

SMALLEST_SHARE = 1e-6
_LEFT_OUT = "position is left out: it cannot be told apart from condition in these orders"


@dataclass(frozen=True)
class Ratio:
    """One effect of the model, back from logarithms: the ratio of first to second, and its test."""

    measure: str
    first: str
    second: str
    ratio: float
    low: float
    high: float
    log_difference: float
    standard_error: float
    t: float
    df: int
    p: float | None
    p_holm: float | None = None


@dataclass(frozen=True)
class LogModel:
    """A fitted model. `method` is `mixed` or `fixed`; `reason` says why it is not `mixed`.

    `columns` name the coefficients; `covariance` is theirs. Variances are of logarithms.
    """

    measure: str
    method: str
    reason: str
    note: str
    n: int
    rows: int
    df: int
    columns: tuple[str, ...]
    coefficients: Floats
    covariance: Floats
    participant_sd: float | None
    residual_sd: float
    with_position: bool


def fit_log_model(design: Design, *, with_position: bool = True) -> LogModel:
    """Fit the model to all readings of a design.

    Errors: Untestable with fewer than 2 participants or conditions, with values that have no
    logarithm, or if nothing varies within participants beyond the effects.
    """
    require(design, 2)
    if any(reading.value <= 0 for reading in design.readings):
        raise Untestable(f"{design.measure} has values of 0 or less, which have no logarithm")
    rows = describe_rows(design)
    note = ""
    if with_position and _lacks_rank(rows, rows.conditions, rows.positions):
        with_position, note = False, _LEFT_OUT
    fixed = np.column_stack([rows.conditions, rows.positions]) if with_position else rows.conditions
    names = (*rows.condition_names, *(rows.position_names if with_position else ()))
    y = np.log(rows.values)
    own = within(rows, fixed)
    rest = left_over(own, within(rows, y[:, np.newaxis])[:, 0])
    df = len(y) - design.n - rank_of(own)
    if df < 1 or not has_spread(rest, y):
        raise Untestable("nothing varies within participants beyond condition and position")
    model = LogModel(
        measure=design.measure,
        method="mixed",
        reason="",
        note=note,
        n=design.n,
        rows=len(y),
        df=df,
        columns=("intercept", *names),
        coefficients=np.empty(0),
        covariance=np.empty((0, 0)),
        participant_sd=None,
        residual_sd=0.0,
        with_position=with_position,
    )
    unit = float(rest @ rest / df) ** 0.5
    return _fit_mixed(model, y, fixed, rows, unit) or _fit_fixed(model, y, fixed, own, unit)


def compare_conditions(model: LogModel, pairs: Pairs) -> tuple[Ratio, ...]:
    """Ratios of conditions with intervals; p with Holm for planned pairs, none for others."""
    found = [_compare(model, first, second) for first, second in pairs.pairs]
    if not pairs.planned:
        return tuple(replace(one, p=None) for one in found)
    corrected = adjust_holm([one.p for one in found])
    return tuple(replace(one, p_holm=p) for one, p in zip(found, corrected, strict=True))


def compare_positions(model: LogModel) -> tuple[Ratio, ...]:
    """Ratios of each later position to the first; empty if position is not in the model."""
    later = [name for name in model.columns if name.startswith("position ")]
    return tuple(_compare(model, name, "position 1") for name in later)


def adjusted_means(model: LogModel, conditions: tuple[str, ...]) -> dict[str, float]:
    """Geometric mean per condition for the average participant, positions weighted equally."""
    later = [k for k, name in enumerate(model.columns) if name.startswith("position ")]
    shift = sum(float(model.coefficients[k]) for k in later) / (len(later) + 1)
    base = float(model.coefficients[0]) + shift
    means = {}
    for name in conditions:
        own = model.coefficients[model.columns.index(name)] if name in model.columns else 0.0
        means[name] = float(np.exp(base + own))
    return means


def _lacks_rank(rows: ModelRows, conditions: Floats, positions: Floats) -> bool:
    both = within(rows, np.column_stack([conditions, positions]))
    return rank_of(both) < rank_of(within(rows, conditions)) + int(positions.shape[1])


def _fit_mixed(
    model: LogModel, y: Floats, fixed: Floats, rows: ModelRows, unit: float
) -> LogModel | None:
    """The mixed fit, or None where the fallback is due.

    `unit` is the spread within participants: the fit runs in it, since the library's optimisers
    and its own warnings about boundaries depend on the scale.
    """
    exog = np.column_stack([np.ones(len(y)), fixed])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            fit = MixedLM(y / unit, exog, rows.participants).fit(
                reml=True, method=["bfgs", "powell", "cg"]
            )
        except (np.linalg.LinAlgError, ValueError, ZeroDivisionError):
            return None
    size = exog.shape[1]
    between = float(np.asarray(fit.cov_re)[0, 0]) * unit**2
    within = float(fit.scale) * unit**2
    covariance = np.asarray(fit.cov_params(), np.float64)[:size, :size] * unit**2
    sound = fit.converged and np.isfinite(covariance).all() and within > 0
    if not sound or between <= SMALLEST_SHARE * within:
        return None
    return replace(
        model,
        coefficients=np.asarray(fit.fe_params, np.float64) * unit,
        covariance=covariance,
        participant_sd=between**0.5,
        residual_sd=within**0.5,
    )


def _fit_fixed(model: LogModel, y: Floats, fixed: Floats, own: Floats, unit: float) -> LogModel:
    """Least squares with participants as fixed effects; the intercept is their mean.

    `own` are the columns of `fixed` as deviations within participants, `unit` the residual SD.
    """
    slopes = np.linalg.lstsq(own, y, rcond=None)[0]
    spread = unit**2 * np.linalg.pinv(own.T @ own)
    middle = fixed.mean(axis=0)
    toward = -spread @ middle
    corner = unit**2 / len(y) + middle @ spread @ middle
    return replace(
        model,
        method="fixed",
        reason="the mixed model's fit was singular, so participants are fixed effects",
        coefficients=np.concatenate([[y.mean() - middle @ slopes], slopes]),
        covariance=np.block([[corner, toward[np.newaxis, :]], [toward[:, np.newaxis], spread]]),
        residual_sd=unit,
    )


def _compare(model: LogModel, first: str, second: str) -> Ratio:
    weights = np.zeros(len(model.columns))
    for name, sign in ((first, 1.0), (second, -1.0)):
        if name in model.columns:
            weights[model.columns.index(name)] += sign
    difference = float(weights @ model.coefficients)
    error = float(weights @ model.covariance @ weights) ** 0.5
    reach = float(stats.t.ppf((1 + LEVEL) / 2, model.df)) * error
    t = difference / error
    return Ratio(
        measure=model.measure,
        first=first,
        second=second,
        ratio=float(np.exp(difference)),
        low=float(np.exp(difference - reach)),
        high=float(np.exp(difference + reach)),
        log_difference=difference,
        standard_error=error,
        t=t,
        df=model.df,
        p=float(2 * stats.t.sf(abs(t), model.df)),
    )
