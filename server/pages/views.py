"""What each participant page says: a template and its values, made from the visit alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

from server.desks.participants import Visit
from study.protocol.device import FIELDS
from study.protocol.displays import SHOWN, display_label
from study.protocol.flow import step_kind
from study.protocol.lifecycle import OUTCOMES, Outcome


@dataclass(frozen=True)
class View:
    """A template and its values."""

    template: str
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Typed:
    """What somebody typed into a form and what was wrong with it."""

    values: Mapping[str, str]
    problems: Mapping[str, str]


NOTHING_TYPED = Typed({}, {})


def view_step(visit: Visit, address: str, typed: Typed = NOTHING_TYPED) -> View:
    """The page of the participant's current step, with what was typed if a form came back."""
    step = visit.participant.progress.page
    values = frame_values(visit, address) | {"step": step}
    if step in OUTCOMES or step == "debrief":
        return View("ended.html", values | _ended_values(visit))
    kind, position = step_kind(step)
    if kind in ("practice", "trial"):
        heading = "Practice" if position is None else display_label(position)
        return View("play.html", values | {"heading": heading})
    if kind == "explanation" and position is not None:
        return View("explanation.html", values | _explanation_values(visit, position))
    if kind == "instructions":
        tries = visit.participant.progress.practice_tries
        heading = visit.study.texts.instructions.title
        return View("instructions.html", values | {"heading": heading, "tries_used": tries})
    values |= {"values": typed.values, "problems": typed.problems}
    if kind == "browser-check":
        heading = visit.study.texts.browser_check.title
        return View("browser-check.html", values | {"heading": heading, "fields": FIELDS})
    return _items_view(visit, values)


def view_withdrawal(visit: Visit, address: str) -> View:
    """The page that asks before withdrawing."""
    return View("withdraw.html", frame_values(visit, address) | {"heading": "Withdraw?"})


def frame_values(visit: Visit, address: str) -> dict[str, Any]:
    """What every participant page needs."""
    progress, plan = visit.participant.progress, visit.study.plan
    early = progress.page in OUTCOMES
    return {
        "study": visit.study,
        "address": address,
        "code": visit.participant.code,
        "can_withdraw": progress.outcome != "withdrawn",
        "ended": progress.outcome is not None,
        "progress": None
        if early
        else {
            "step_number": plan.steps.index(progress.step) + 1,
            "steps": len(plan.steps),
        },
    }


def _items_view(visit: Visit, values: dict[str, Any]) -> View:
    """A page of items; its title is that of its first instrument."""
    step = visit.participant.progress.step
    kind, position = step_kind(step)
    instruments = visit.instruments(kind)
    if not instruments:
        raise LookupError(f"the step kind {kind} has no page")
    heading = instruments[0].title
    if position is not None:
        heading = f"{heading} ({display_label(position)})"
    if kind == "consent":
        heading = visit.study.texts.consent.title
    steps = visit.study.plan.steps
    is_last = steps.index(step) == len(steps) - 2
    labels = {item.name: item.label.rstrip(".") for one in instruments for item in one.items}
    return View(
        "consent.html" if kind == "consent" else "items.html",
        values
        | {
            "instruments": instruments,
            "heading": heading,
            "button": "Finish the study" if is_last else "Save and go on",
            "labels": labels,
        },
    )


def _explanation_values(visit: Visit, position: int) -> dict[str, Any]:
    """Exactly the elements that the coming trial's condition can show."""
    study, slot = visit.study, visit.participant.slot
    if slot is None:
        raise LookupError("an explanation is shown before an order was given")
    shown = SHOWN[study.orders[slot.order_index][position - 1]]
    texts = {element.name: element for element in study.texts.elements}
    how = study.texts.plain_display
    if shown.names:
        how = study.texts.adaptive_display if shown.adaptive else study.texts.steady_display
    return {
        "heading": f"Round {position}: {display_label(position)}",
        "label": display_label(position),
        "position": position,
        "rounds": study.plan.trials,
        "elements": [texts[name] for name in shown.names],
        "how": how,
    }


def _ended_values(visit: Visit) -> dict[str, Any]:
    outcome = cast("Outcome", visit.participant.progress.life.told)
    texts = visit.study.texts
    text = {
        "completed": texts.debrief,
        "screened-out": texts.screened_out,
        "withdrawn": texts.withdrawn,
        "timed-out": texts.timed_out,
        "excluded": texts.excluded,
    }[outcome]
    return {
        "text": text,
        "heading": text.title,
        "completion_code": visit.study.completion_codes.get(outcome, ""),
        "can_return": _may_return(visit, outcome),
        "code_caption": "Your completion code" if outcome == "completed" else "Your code",
        "code_advice": "If you came from a recruitment panel, enter this code there. "
        "Otherwise there is nothing more to do.",
    }


def _may_return(visit: Visit, outcome: Outcome) -> bool:
    """Whether the study names an address of the panel for this outcome."""
    ending = visit.study.endings.get(outcome)
    return ending is not None and ending.host in visit.study.panel.hosts
