"""The report's part about people: who took part, who counts, who was left out and why."""

from __future__ import annotations

from collections import Counter

import numpy as np

from study.analysis.cases import (
    StudyData,
    count_orders,
    count_statuses,
    everyone_left_out,
    label_condition,
    team_design,
)
from study.analysis.descriptives import summarise
from study.analysis.designs import Design
from study.analysis.sheets import RowsBehind, Section, Sheet, View, make_sheet
from study.analysis.wording import capitalise, count, number

RULE = (
    "Complete cases: a participant counts for a team measure with a completed trial in every "
    "condition, and for an item of the questionnaire with an answer after every condition, "
    "whatever page the participation ended on. Excluded participants never count. Nothing is "
    "filled in."
)
_ONCE = {"choice", "number", "scale", "rating", "slider"}
_UNASKED = {"browser_check"}


def describe_people(data: StudyData) -> Section:
    """Counts by status and order, the answers given once, and everybody who was left out."""
    design = team_design(data, "sum_wait_s")
    excluded = len(data.people) - len(data.counted)
    told = (
        f"{count(len(data.people), 'participant')} in this mode; {count(excluded, 'participant')} "
        f"excluded; {count(design.n, 'participant')} with complete data for the team measures."
    )
    sentences = [capitalise(told), RULE]
    if data.marked_people or data.marked_trials:
        marked = (
            f"{count(data.marked_people, 'participant')} and {count(data.marked_trials, 'trial')}"
        )
        fate = "counted here all the same, as was asked" if data.keeps_marked else "left out"
        sentences.append(f"Exclusion rules of the study mark {marked}; what they mark is {fate}.")
    if len(data.versions) > 1:
        sentences.append(
            f"The participants joined {len(data.versions)} versions of the study "
            f"({', '.join(version[:8] for version in data.versions)}); they are analysed together."
        )
    if len(design.readings) > design.values.size:
        sentences.append("Some met a condition more than once; their figures are averaged.")
    blocks = [_statuses(data), _orders(data, design), _left_out(data, design)]
    background = _background(data, design)
    if background.rows:
        blocks.append(background)
    return Section("people", "Who took part", tuple(sentences), tuple(blocks))


def _statuses(data: StudyData) -> Sheet:
    found = count_statuses(data)
    rows = [{"status": status, "participants": n} for status, n in found.items()]
    views = (
        View("Status", "text", ("status",)),
        View("Participants", "plain", ("participants",)),
    )
    everybody = len(data.people)
    behind = RowsBehind("participants.csv", data.mode_filter, everybody, everybody)
    return make_sheet(
        "statuses", "Participants by status", rows, ("status", "participants"), views, behind
    )


def _orders(data: StudyData, design: Design) -> Sheet:
    complete = count_orders(data, design.participants)
    rows = [
        {
            "order": order,
            "shown": " > ".join(label_condition(name) for name in order.split(">")),
            "participants": n,
            "complete": complete.get(order, 0),
        }
        for order, n in count_orders(data, tuple(p.code for p in data.people)).items()
        if order
    ]
    views = (
        View("Order of conditions", "text", ("shown",)),
        View("Joined", "plain", ("participants",)),
        View("Complete", "plain", ("complete",)),
    )
    header = ("order", "shown", "participants", "complete")
    placed = sum(bool(person.order) for person in data.people)
    where = f"{data.mode_filter} and condition_order is not empty"
    behind = RowsBehind("participants.csv", where, placed, placed)
    return make_sheet("orders", "Participants by order", rows, header, views, behind)


def _left_out(data: StudyData, design: Design) -> Sheet:
    found = everyone_left_out(data, design)
    rows = [{"participant_code": one.participant, "reason": one.reason} for one in found]
    views = (View("Participant", "code", ("participant_code",)), View("Why", "text", ("reason",)))
    behind = RowsBehind(
        "participants.csv",
        f"{data.mode_filter}, without complete data",
        len(found),
        len(found),
    )
    return make_sheet(
        "left_out",
        "Left out of the team measures",
        rows,
        ("participant_code", "reason"),
        views,
        behind,
    )


def _background(data: StudyData, design: Design) -> Sheet:
    """Answers given once, of those who count for the team measures."""
    kept, rows = set(design.participants), []
    used: list[str] = []
    for item in data.items:
        given = [
            answer
            for answer in data.answers
            if (answer.instrument, answer.item) == (item.instrument, item.name)
            and answer.participant in kept
            and answer.value
        ]
        answers = [answer.value for answer in given]
        once = item.instrument not in _UNASKED and not any(answer.condition for answer in given)
        if not answers or not once or item.kind not in _ONCE:
            continue
        used += [answer.participant for answer in given]
        text = _describe_number(answers) if item.kind == "number" else ""
        labels = dict(item.levels)
        text = text or ", ".join(
            f"{labels.get(value, value)} {n}" for value, n in Counter(answers).most_common()
        )
        rows.append(
            {"item": f"{item.instrument}.{item.name}", "wording": item.wording, "answers": text}
        )
    views = (View("Question", "text", ("wording",)), View("Answers", "text", ("answers",)))
    behind = RowsBehind(
        "responses.csv",
        f"{data.mode_filter} and condition is empty, of those with complete data",
        len(used),
        len(set(used)),
    )
    return make_sheet(
        "background", "Asked once", rows, ("item", "wording", "answers"), views, behind
    )


def _describe_number(answers: list[str]) -> str:
    figures = [float(value) for value in answers if value.replace(".", "", 1).isdecimal()]
    if not figures:
        return ""
    found = summarise(np.array(figures))
    told = f"mean {number(found.mean)}"
    told += f", SD {number(found.sd)}" if found.sd is not None else ""
    told += f", {number(found.smallest)} to {number(found.largest)} (N = {found.n})"
    others = len(answers) - len(figures)
    return f"{told}; {others} without a figure" if others else told
