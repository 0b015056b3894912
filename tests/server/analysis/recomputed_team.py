"""The tables of the team measures, computed again with pandas, scipy and statsmodels."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pandas as pd
from scipy import optimize, stats
from statsmodels.formula.api import mixedlm, ols
from statsmodels.stats.anova import AnovaRM, anova_lm
from statsmodels.stats.power import TTestPower

from tests.server.analysis.facts import MEASURES, Facts, Rows, holm, summary

EFFECTS = "C(condition, Treatment('varil')) + C(position)"
LADDER = (12, 18, 24, 30, 36, 48, 60)


def describe(facts: Facts) -> dict[str, Rows]:
    """Descriptives per condition and position, and the figures that the tests used."""
    tables: dict[str, Rows] = {"team_descriptives": [], "positions": [], "cases": []}
    for measure, what in MEASURES.items():
        rows, same = facts.cases(measure), {"measure": measure, "what": what}
        for name in facts.conditions:
            found = summary(rows.loc[rows["condition"] == name, "value"])
            tables["team_descriptives"].append(same | {"condition": name} | found)
        for position, values in rows.groupby("position")["value"]:
            tables["positions"].append(same | {"position": position} | summary(values))
        tables["cases"] += [
            {"measure": measure, "participant": row.participant_code, "condition": row.condition,
             "position": row.position, "value": row.value}
            for row in rows.itertuples()
        ]  # fmt: skip
    return tables


def primary(facts: Facts, *, is_mixed: bool) -> dict[str, Rows]:
    """The mixed model by statsmodels' formulas, or least squares with a column per participant.

    Which of the two the report told; that the fallback was due is checked here.
    """
    rows = facts.cases("sum_wait_s")
    rows["log"] = np.log(rows["value"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fit = mixedlm(f"log ~ {EFFECTS}", rows, groups="participant_code").fit(method="powell")
    between, residual = float(fit.cov_re.iloc[0, 0]) ** 0.5, float(fit.scale) ** 0.5
    fixed = ols(f"log ~ {EFFECTS} + C(participant_code)", rows).fit()
    if not is_mixed:
        assert between < 0.05 * residual
        fit, between, residual = fixed, np.nan, float(fixed.mse_resid) ** 0.5
    df = int(fixed.df_resid)
    n, size = rows["participant_code"].nunique(), len(rows)

    def ratio(key: str, sign: int) -> dict[str, Any]:
        estimate, error = sign * fit.params[key], fit.bse[key]
        reach = stats.t.ppf(0.975, df) * error
        low, high = np.exp(estimate - reach), np.exp(estimate + reach)
        t = estimate / error
        p = 2 * stats.t.sf(abs(t), df)
        return {"ratio": np.exp(estimate), "low": low, "high": high, "t": t, "df": df, "p": p,
                "log_difference": estimate, "standard_error": error}  # fmt: skip

    contrasts: Rows = [
        {"first": first, "second": second, "n": n, "rows": size}
        | ratio(f"C(condition, Treatment('varil'))[T.{second}]", -1)
        for first, second in facts.pairs
    ]
    for row, p in zip(contrasts, holm([row["p"] for row in contrasts]), strict=True):
        row["p_holm"] = p
    later = sorted(rows["position"].unique())[1:]
    positions = []
    for place in later:
        found = ratio(f"C(position)[T.{place}]", 1)
        kept = {key: found[key] for key in ("ratio", "low", "high", "t", "df", "p")}
        positions.append({"first": f"position {place}", "second": "position 1"} | kept)
    people = rows["participant_code"].unique()
    grid = pd.MultiIndex.from_product(
        [facts.conditions, sorted(rows["position"].unique()), people],
        names=["condition", "position", "participant_code"],
    ).to_frame(index=False)
    grid["log"] = fit.predict(grid)
    means = np.exp(grid.groupby("condition")["log"].mean())
    model: Rows = [
        {"quantity": f"adjusted geometric mean, {name.upper()} (s)", "value": means[name]}
        for name in facts.conditions
    ]
    model.append({"quantity": "SD between participants (log)", "value": between})
    model.append({"quantity": "residual SD (log)", "value": residual})
    return {"primary_contrasts": contrasts, "primary_model": model, "position_ratios": positions}


def secondary(facts: Facts) -> dict[str, Rows]:
    """F by AnovaRM, sphericity by its definitions, paired t and dz by scipy."""
    tables: dict[str, Rows] = {"anova": [], "paired_contrasts": []}
    for measure in ("sum_completion_s", "slowest_robot_s"):
        rows = facts.cases(measure)
        tables["anova"].append({"measure": measure} | _anova(rows, facts.wide(rows)))
        own = [_paired(facts.wide(rows), *pair) for pair in facts.pairs]
        for row, p in zip(own, holm([row["p"] for row in own]), strict=True):
            tables["paired_contrasts"].append({"measure": measure, "p_holm": p, "note": ""} | row)
    return tables


def _anova(rows: pd.DataFrame, table: pd.DataFrame) -> dict[str, Any]:
    found = AnovaRM(rows, "value", "participant_code", within=["condition"]).fit().anova_table
    f = float(found["F Value"].iloc[0])
    n, k = table.shape
    d, df_error = k - 1, (n - 1) * (k - 1)
    center = np.eye(k) - 1 / k
    roots = np.linalg.eigvalsh(center @ np.cov(table.to_numpy().T) @ center)[1:]
    gg = roots.sum() ** 2 / (d * (roots**2).sum())
    hf = min(1.0, max(gg, (n * d * gg - 2) / (d * (n - 1 - d * gg))))
    w = roots.prod() / roots.mean() ** d
    chi = max(0.0, -(n - 1 - (2 * d**2 + d + 2) / (6 * d)) * np.log(w))
    df = d * (d + 1) // 2 - 1
    assert d == 2, "Box's second-order term vanishes for three conditions only"
    mean = rows["value"].mean()
    conditions = ((rows.groupby("condition")["value"].transform("mean") - mean) ** 2).sum()
    people = ((rows.groupby("participant_code")["value"].transform("mean") - mean) ** 2).sum()
    total = ((rows["value"] - mean) ** 2).sum()
    return {
        "n": n, "f": f, "df_conditions": d, "df_error": df_error,
        "df_conditions_corrected": d * gg, "df_error_corrected": df_error * gg,
        "p": stats.f.sf(f, d * gg, df_error * gg),
        "p_uncorrected": float(found["Pr > F"].iloc[0]),
        "p_huynh_feldt": stats.f.sf(f, d * hf, df_error * hf),
        "partial_eta_squared": conditions / (total - people),
        "generalised_eta_squared": conditions / total,
        "mauchly_w": w, "chi_squared": chi, "df": df, "mauchly_p": stats.chi2.sf(chi, df),
        "greenhouse_geisser": gg, "huynh_feldt": hf,
    }  # fmt: skip


def _paired(table: pd.DataFrame, first: str, second: str) -> dict[str, Any]:
    test = stats.ttest_rel(table[first], table[second])
    interval, n = test.confidence_interval(), len(table)
    sd = (table[first] - table[second]).std()
    t = float(test.statistic)

    def miss(c: float, tail: float) -> float:
        return float(stats.nct.cdf(t, n - 1, c)) - tail

    def centre(tail: float) -> float:
        """The noncentral t's centre under which t has this lower tail, looked for from t on."""
        step = -0.25 if tail > 0.5 else 0.25
        near = t
        while miss(near, tail) * miss(near + step, tail) > 0:
            near += step
        return float(optimize.brentq(miss, near, near + step, args=(tail,)))

    return {
        "first": first, "second": second, "n": n, "t": t, "df": n - 1, "p": test.pvalue,
        "difference": (table[first] - table[second]).mean(), "sd": sd,
        "low": interval.low, "high": interval.high, "dz": t / n**0.5,
        "dz_low": centre(0.975) / n**0.5, "dz_high": centre(0.025) / n**0.5,
    }  # fmt: skip


def order_effects(facts: Facts) -> Rows:
    """Nested least-squares models with a column per participant, by statsmodels' anova_lm."""
    found: Rows = []
    for measure in MEASURES:
        rows = facts.cases(measure).sort_values(["participant_code", "position"])
        is_log = measure == "sum_wait_s"
        rows["y"] = np.log(rows["value"]) if is_log else rows["value"]
        rows["before"] = rows.groupby("participant_code")["condition"].shift(fill_value="")
        for name in facts.conditions:
            rows[f"after_{name}"] = (rows["before"] == name).astype(float)
        after = " + ".join(f"after_{name}" for name in facts.conditions)
        base = "y ~ C(participant_code) + C(condition)"
        models = [base, f"{base} + C(position)", f"{base} + C(position) + {after}"]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # who was met before tells the first position, too
            fits = [ols(model, rows).fit() for model in models]
        for what, small, large in zip(
            ("position", "previous condition"), fits[:2], fits[1:], strict=True
        ):
            if large.df_resid < 1 or small.df_resid - large.df_resid < 1:
                continue
            last = anova_lm(small, large).iloc[1]
            found.append(
                {"measure": measure, "what": what, "scale": "log" if is_log else "raw",
                 "n": rows["participant_code"].nunique(), "rows": len(rows), "f": last["F"],
                 "df": last["df_diff"], "df_error": last["df_resid"], "p": last["Pr(>F)"],
                 "partial_eta_squared": last["ss_diff"] / (last["ss_diff"] + last["ssr"])}
            )  # fmt: skip
    return found


def detectable(facts: Facts, planned: int | None) -> Rows:
    """80 % power by statsmodels; translated by the spread of the paired differences."""
    spreads = {}
    for measure in MEASURES:
        table = facts.wide(facts.cases(measure))
        table = np.log(table) if measure == "sum_wait_s" else table
        spreads[measure] = np.mean([(table[a] - table[b]).var() for a, b in facts.pairs]) ** 0.5
    present = len(facts.wide(facts.cases("sum_wait_s")))
    rows: Rows = []
    for n in sorted({*LADDER, present, *([planned] if planned else [])}):
        solve = TTestPower().solve_power
        dz, strict = (solve(nobs=n, alpha=a, power=0.8) for a in (0.05, 0.05 / len(facts.pairs)))
        marks = [name for name, own in (("planned", planned), ("present", present)) if own == n]
        row = {"n": n, "which": " and ".join(marks), "dz": dz, "dz_strictest": strict}
        row |= {measure: strict * spread for measure, spread in spreads.items()}
        rows.append(row | {"sum_wait_s": np.exp(-row["sum_wait_s"])})
    return rows
