"""Exclusion rules: declared in the study before any data, applied as flags, never as deletions.

A rule holds one measure of a trial against a bound. `per = "trial"` flags every trial beyond it;
`per = "participant"` flags a participant whose trials, taken together as the measure says, lie
beyond it. What was not measured is flagged by no rule.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from study.protocol.records import NAME_PATTERN, Problem, Record, refuse

Together = Literal["sum", "median", "highest", "lowest"]


@dataclass(frozen=True)
class Measure:
    """A figure of one trial that rules may be about.

    `together`: how the figures of a participant's trials become one.
    """

    name: str
    unit: str
    together: Together
    meaning: str


QUALITY_MEASURES: tuple[Measure, ...] = (
    Measure("rtt_median_ms", "ms", "median", "round-trip time, median"),
    Measure("rtt_p95_ms", "ms", "highest", "round-trip time that 95 % stayed below"),
    Measure("frame_rate_median_hz", "Hz", "median", "frames drawn a second, median"),
    Measure("frame_rate_p5_hz", "Hz", "lowest", "frame rate that 95 % of the seconds exceeded"),
    Measure("long_frames", "", "sum", "frames that took longer than 50 ms"),
    Measure("longest_frame_ms", "ms", "highest", "the longest time that one frame took"),
    Measure("hidden_s", "s", "sum", "time in which the page was hidden"),
    Measure("unfocused_s", "s", "sum", "time in which the page did not have the keyboard"),
    Measure("pointer_lock_losses", "", "sum", "how often the pointer was set free"),
    Measure("pauses", "", "sum", "how often the world was paused"),
    Measure("paused_s", "s", "sum", "how long the world was paused"),
    Measure("idle_s", "s", "sum", "time without any input of 5 s or longer at a stretch"),
    Measure("tick_late_p99_ms", "ms", "highest", "lateness that 99 % of the ticks stayed below"),
    Measure("tick_late_max_ms", "ms", "highest", "lateness of the latest tick"),
    Measure("connections", "", "sum", "how often the page connected"),
)
TRIAL_MEASURES: tuple[Measure, ...] = (
    Measure("duration_s", "s", "sum", "time until every robot was home"),
    Measure("human_path_m", "m", "sum", "length of the person's way"),
    Measure("human_still_s", "s", "sum", "time in which the person stood still"),
    Measure("blocked_by_human_s", "s", "sum", "time in which the person blocked a bay"),
)
MEASURES: Mapping[str, Measure] = MappingProxyType(
    {measure.name: measure for measure in (*QUALITY_MEASURES, *TRIAL_MEASURES)}
)
"""Every measure by name; the names are columns of quality.csv and trials.csv."""


class ExclusionRule(Record):
    """One rule of a study file: `measure` above or below a bound, and what that is called."""

    name: Annotated[str, Field(pattern=NAME_PATTERN)]
    measure: str
    above: float | None = Field(None, allow_inf_nan=False)
    below: float | None = Field(None, allow_inf_nan=False)
    per: Literal["trial", "participant"] = "trial"
    reason: Annotated[str, Field(max_length=200)] = ""

    @model_validator(mode="after")
    def _check_rule(self) -> Self:
        if self.measure not in MEASURES:
            known = ", ".join(MEASURES)
            refuse([Problem(("measure",), self.measure, f"there is no such measure; use {known}")])
        if (self.above is None) == (self.below is None):
            bounds = {"above": self.above, "below": self.below}
            refuse([Problem((), bounds, "give exactly one of `above` and `below`")])
        return self

    def applies_to(self, figure: float | None) -> bool:
        """Whether a figure lies beyond the bound; one that was not measured never does."""
        if figure is None:
            return False
        return figure > self.above if self.above is not None else figure < (self.below or 0.0)

    @property
    def sentence(self) -> str:
        """The rule in words: “hidden_s above 20 s (per trial)”."""
        side, bound = ("above", self.above) if self.above is not None else ("below", self.below)
        unit = MEASURES[self.measure].unit
        return f"{self.measure} {side} {bound:g}{' ' if unit else ''}{unit} (per {self.per})"


Figures = Mapping[str, float | None]


def flag_trial(rules: Iterable[ExclusionRule], figures: Figures) -> list[str]:
    """Names of the rules per trial that one trial's figures break."""
    return [
        rule.name
        for rule in rules
        if rule.per == "trial" and rule.applies_to(figures.get(rule.measure))
    ]


def flag_participant(rules: Iterable[ExclusionRule], trials: Sequence[Figures]) -> list[str]:
    """Names of the rules per participant that the figures of their ended trials break."""
    return [
        rule.name
        for rule in rules
        if rule.per == "participant" and rule.applies_to(take_together(rule.measure, trials))
    ]


def take_together(measure: str, trials: Sequence[Figures]) -> float | None:
    """One figure of a participant's trials; None if it was measured in none of them."""
    figures = [value for trial in trials if (value := trial.get(measure)) is not None]
    if not figures:
        return None
    together = MEASURES[measure].together
    if together == "sum":
        return sum(figures)
    if together == "median":
        return statistics.median(figures)
    return max(figures) if together == "highest" else min(figures)
