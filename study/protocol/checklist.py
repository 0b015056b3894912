"""What must be in order before a study is launched, each point green or red with its reason."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from study.config import Study
from study.protocol.orders import count_successions

State = Literal["done", "problem", "open"]
_PLACEHOLDER = re.compile(r"\b(TODO|XXX|example\.org|example\.com|Lorem ipsum)\b")
"""What stands where somebody meant to write; whole words, since codes are drawn of letters."""


@dataclass(frozen=True)
class Surroundings:
    """What the study itself does not know.

    `tried`: completed participants of pilots or bots; `policy_origin`: of the policy it runs, None
    if it runs none; `is_https`: whether this page was reached over https.
    """

    tried: int
    policy_origin: str | None
    time_scale: float
    is_https: bool


@dataclass(frozen=True)
class Point:
    """One point of the checklist; “open” points are a matter of judgement."""

    title: str
    state: State
    detail: str


def check_launch(study: Study, around: Surroundings) -> tuple[Point, ...]:
    """The points in the order in which one would see to them."""
    return (
        _consent(study),
        _texts(study),
        _plan(study),
        _orders(study),
        _endings(study),
        _rules(study),
        _policy(study, around),
        _trials_run(around),
        _speed(around),
        _encryption(around),
        _recruiting(study),
    )


def _consent(study: Study) -> Point:
    asked = sum(item.required for item in study.consent.items)
    if not asked:
        return Point("Consent", "problem", "the consent page asks for nothing that must be agreed")
    what = "1 statement" if asked == 1 else f"{asked} statements"
    return Point("Consent", "done", f"{what} must be agreed to")


def _texts(study: Study) -> Point:
    if found := _PLACEHOLDER.search(study.canonical_json.replace("\\n", "\n")):
        return Point("Texts", "problem", f"they still hold “{found[0]}”: write your own there")
    reached = f"who has questions is sent to {study.texts.contact}"
    return Point("Texts", "open", f"read every page below as a participant would; {reached}")


def _plan(study: Study) -> Point:
    planned = study.planned_participants
    if planned is None:
        return Point(
            "Sample size", "problem", "“planned_participants” is not set in the study file"
        )
    if planned % len(study.orders):
        detail = f"{planned} participants do not fill {len(study.orders)} orders evenly"
        return Point("Sample size", "open", detail)
    return Point("Sample size", "done", f"{planned}, {planned // len(study.orders)} per order")


def _orders(study: Study) -> Point:
    title = "Orders of the conditions"
    if len(study.conditions) == 1:
        return Point(title, "open", "there is only one condition, nothing to counterbalance")
    successions = set(count_successions(study.orders).values())
    if len(successions) > 1:
        return Point(title, "open", "some conditions follow one another more often than others")
    return Point(title, "done", f"{len(study.orders)} orders, balanced for what follows what")


def _endings(study: Study) -> Point:
    title = "Completion codes"
    codes = list(study.completion_codes.values())
    if len(set(codes)) < len(codes):
        return Point(title, "problem", "two outcomes share a code: a panel could not tell them")
    return Point(title, "done", f"{len(codes)} outcomes, each with its own code")


def _rules(study: Study) -> Point:
    title = "Exclusion rules"
    if not study.exclusion:
        return Point(title, "open", "none is declared; declare them before the first participant")
    return Point(title, "done", "; ".join(rule.sentence for rule in study.exclusion))


def _policy(study: Study, around: Surroundings) -> Point:
    title = "Policy of the adaptive display"
    if around.policy_origin is None:
        return Point(title, "done", "no condition runs one")
    if around.policy_origin == "simulated":
        state: State = "problem" if study.recruiting == "live" else "open"
        return Point(title, state, "it was learned from simulated people")
    if around.policy_origin == "initial":
        return Point(title, "open", "it is the initial one: nothing was learned yet")
    return Point(title, "done", "it was learned from people")


def _trials_run(around: Surroundings) -> Point:
    if not around.tried:
        return Point("Rehearsal", "problem", "nobody completed it yet: try it with pilots or bots")
    return Point("Rehearsal", "done", f"{around.tried} completed it as pilots or bots")


def _speed(around: Surroundings) -> Point:
    if around.time_scale != 1.0:
        return Point("Real time", "problem", f"worlds run {around.time_scale:g} times as fast")
    return Point("Real time", "done", "worlds run in real time")


def _encryption(around: Surroundings) -> Point:
    if around.is_https:
        return Point("Encrypted connection", "done", "this page came over https")
    return Point("Encrypted connection", "problem", "this page came over plain http")


def _recruiting(study: Study) -> Point:
    if study.recruiting == "live":
        return Point("Recruiting", "done", "participants count as live")
    return Point(
        "Recruiting",
        "open",
        "participants count as pilots until “recruiting” is “live” in the study file",
    )
