"""One-way repeated-measures analysis of variance with corrected degrees of freedom."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from study.analysis.descriptives import has_spread
from study.analysis.designs import Design, Untestable, require
from study.analysis.sphericity import Sphericity, measure_sphericity


@dataclass(frozen=True)
class Anova:
    """F test of the conditions of one measure.

    `p` is the Greenhouse-Geisser one, the one to report; `p_uncorrected` assumes sphericity.
    """

    measure: str
    n: int
    f: float
    df_conditions: int
    df_error: int
    df_conditions_corrected: float
    df_error_corrected: float
    p: float
    p_uncorrected: float
    p_huynh_feldt: float
    partial_eta_squared: float
    generalised_eta_squared: float
    sphericity: Sphericity


def analyse_variance(design: Design) -> Anova:
    """Test whether the conditions' means are equal.

    Errors: Untestable with fewer than 2 complete participants or 2 conditions, or if participants
    do not differ in how the conditions affect them, which leaves no error to compare with.
    """
    require(design, 2)
    values = design.values
    n, k = values.shape
    grand = values.mean()
    between_conditions = n * float(np.sum((values.mean(axis=0) - grand) ** 2))
    between_people = k * float(np.sum((values.mean(axis=1) - grand) ** 2))
    rest = values - values.mean(axis=0) - values.mean(axis=1, keepdims=True) + grand
    if not has_spread(rest.ravel(), values):
        raise Untestable("the differences between conditions are the same for every participant")
    error = float(np.sum(rest**2))
    df, df_error = k - 1, (n - 1) * (k - 1)
    f = (between_conditions / df) / (error / df_error)
    found = measure_sphericity(values)
    gg, hf = found.greenhouse_geisser, found.huynh_feldt

    def tail(epsilon: float) -> float:
        return float(stats.f.sf(f, df * epsilon, df_error * epsilon))

    return Anova(
        measure=design.measure,
        n=n,
        f=f,
        df_conditions=df,
        df_error=df_error,
        df_conditions_corrected=df * gg,
        df_error_corrected=df_error * gg,
        p=tail(gg),
        p_uncorrected=tail(1.0),
        p_huynh_feldt=tail(hf),
        partial_eta_squared=between_conditions / (between_conditions + error),
        generalised_eta_squared=between_conditions / (between_conditions + between_people + error),
        sphericity=found,
    )
