"""The report's primary analysis: total waiting time by the mixed model of its logarithm."""

from __future__ import annotations

from dataclasses import asdict

from study.analysis.cases import StudyData, label_condition
from study.analysis.designs import Design, Pairs, positive_cases
from study.analysis.mixed import LogModel, Ratio, adjusted_means, compare_conditions, fit_log_model
from study.analysis.report_parts import Tested, attempt, note_plan, word_gaps
from study.analysis.report_team import rows_of
from study.analysis.sheets import Section, Sheet, View, make_sheet
from study.analysis.wording import equals, number, verdict

HEADING = "Primary analysis: total waiting time"
_RATIO_FIELDS = (
    "first", "second", "n", "rows", "ratio", "low", "high", "log_difference", "standard_error",
    "t", "df", "p", "p_holm",
)  # fmt: skip


def run_primary(data: StudyData, design: Design, pairs: Pairs) -> Tested:
    """The mixed model of the logarithm of total waiting time."""
    positive = positive_cases(design)
    model, gaps = attempt("total waiting time", lambda: fit_log_model(positive))
    if model is None:
        return Tested(Section("primary", HEADING, (), (), word_gaps(gaps)), (), tuple(gaps))
    ratios = compare_conditions(model, pairs)
    sentences = [
        _describe_model(model),
        *note_plan(pairs),
    ]
    if zeros := positive.left_out[len(design.left_out) :]:
        sentences.append(
            "Left out here, since a value of 0 has no logarithm: "
            f"{', '.join(one.participant for one in zeros)}."
        )
    findings = tuple(_word_ratio(ratio) for ratio in ratios)
    rows = [asdict(ratio) | {"n": model.n, "rows": model.rows} for ratio in ratios]
    views = (
        View("Contrast", "quotient", ("first", "second")),
        View("N", "plain", ("n",)),
        View("Ratio [95 %]", "interval", ("ratio", "low", "high")),
        View("t", "number", ("t",)),
        View("df", "plain", ("df",)),
        View("p", "p", ("p",)),
        View("p (Holm)", "p", ("p_holm",)),
    )
    contrasts = make_sheet(
        "primary_contrasts",
        "Planned contrasts, as ratios" if pairs.planned else "Pairs, as ratios",
        rows,
        _RATIO_FIELDS,
        views,
        rows_of(data, positive),
    )
    section = Section(
        "primary",
        HEADING,
        tuple(sentences),
        (contrasts, _model_sheet(data, positive, model)),
        findings,
    )
    return Tested(section, findings, ratios=ratios)


def _describe_model(model: LogModel) -> str:
    effects = "condition and position" if model.with_position else "condition"
    if model.method == "mixed":
        how = (
            f"Linear mixed model of log(sum_wait_s) on {effects} with a random intercept per "
            "participant (restricted maximum likelihood), t tests on "
            f"{model.df} residual degrees of freedom within participants (had the fit been "
            "singular, participants would have become fixed effects)"
        )
    else:
        how = (
            f"Fallback: {model.reason} (least squares of log(sum_wait_s) on {effects} and "
            f"participant, {model.df} residual degrees of freedom)"
        )
    note = f"; {model.note}" if model.note else ""
    return f"{how}{note}. A ratio below 1 means shorter waiting in the first condition."


def _word_ratio(ratio: Ratio) -> str:
    first, second = label_condition(ratio.first), label_condition(ratio.second)
    told = (
        f"Total waiting time under {first} was {number(ratio.ratio)} times that under {second} "
        f"(95 % interval {number(ratio.low)} to {number(ratio.high)}"
    )
    if ratio.p_holm is None:
        return f"{told})."
    told += f"; t({ratio.df}) = {number(ratio.t)}, p {equals(ratio.p_holm)} after Holm)"
    return f"{told}: {verdict(ratio.p_holm)}."


def _model_sheet(data: StudyData, design: Design, model: LogModel) -> Sheet:
    rows: list[dict[str, str | float | None]] = [
        {"quantity": f"adjusted geometric mean, {label_condition(name)} (s)", "value": value}
        for name, value in adjusted_means(model, design.conditions).items()
    ]
    rows.append({"quantity": "SD between participants (log)", "value": model.participant_sd})
    rows.append({"quantity": "residual SD (log)", "value": model.residual_sd})
    views = (View("Quantity", "text", ("quantity",)), View("Value", "number", ("value",)))
    return make_sheet(
        "primary_model", "The model", rows, ("quantity", "value"), views, rows_of(data, design)
    )
