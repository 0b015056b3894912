"""What must agree between the parts of a study. Each check tells which keys it reads.

`find_problems(study)` runs all of them; a reader of a file with wrong entries runs those whose keys
are sound, so that all mistakes are reported at once.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from study.errors import LayoutError
from study.protocol.displays import SHOWN
from study.protocol.halls import problem_of
from study.protocol.records import Place, Problem, find_twins
from study.protocol.scoring import scoring_problem
from study.warehouse.halls import PRESETS

if TYPE_CHECKING:
    from study.config import Study

REQUIRED_OUTCOMES = ("completed", "screened-out", "withdrawn", "timed-out")
SECRET = re.compile(r"varil|arroch|crmiar", re.IGNORECASE)
_UNSEEN = frozenset({"use", "source", "scoring"})
Check = Callable[["Study"], Iterator[Problem]]


@dataclass(frozen=True)
class _Registered:
    check: Check
    reads: frozenset[str]


_CHECKS: list[_Registered] = []


def _reads(*keys: str) -> Callable[[Check], Check]:
    def register(check: Check) -> Check:
        _CHECKS.append(_Registered(check, frozenset(keys)))
        return check

    return register


def find_problems(study: Study, unsound: Collection[str] = ()) -> list[Problem]:
    """Everything that does not agree, leaving out checks that read one of the `unsound` keys."""
    return [
        problem
        for entry in _CHECKS
        if not entry.reads & set(unsound)
        for problem in entry.check(study)
    ]


@_reads("conditions")
def _check_conditions(study: Study) -> Iterator[Problem]:
    for later, _ in find_twins(study.conditions):
        name = study.conditions[later]
        yield Problem(("conditions", later), name, "a condition is named twice")


@_reads("conditions", "order")
def _check_orders(study: Study) -> Iterator[Problem]:
    rows = study.order.rows
    if study.order.kind != "fixed":
        if rows:
            yield Problem(
                ("order", "rows"),
                len(rows),
                f"rows belong to `fixed` orders, not to `{study.order.kind}`",
            )
        return
    if not rows:
        yield Problem(("order", "rows"), None, "`fixed` orders need at least one row")
    for number, row in enumerate(rows):
        place = ("order", "rows", number)
        if lacking := [name for name in study.conditions if name not in row]:
            yield Problem(place, list(row), f"this order lacks {', '.join(lacking)}")
        if strange := [name for name in row if name not in study.conditions]:
            yield Problem(place, list(row), f"`conditions` does not have {', '.join(strange)}")
        if twins := [row[later] for later, _ in find_twins(row)]:
            yield Problem(place, list(row), f"this order has {', '.join(twins)} twice")


@_reads("conditions", "scale", "hall", "practice")
def _check_scales(study: Study) -> Iterator[Problem]:
    known = (*PRESETS, *(hall.name for hall in study.hall))
    allowed = f"there is no such hall; use one of: {', '.join(known)}"
    for index, name in enumerate(study.scale):
        if name not in known:
            yield Problem(("scale", index) if len(study.scale) > 1 else ("scale",), name, allowed)
    if len(study.scale) not in (1, len(study.conditions)):
        yield Problem(
            ("scale",),
            list(study.scale),
            f"give one hall for all trials, or one for each of the {len(study.conditions)} trials",
        )
    if study.practice.scale not in known:
        yield Problem(("practice", "scale"), study.practice.scale, allowed)


@_reads("hall")
def _check_halls(study: Study) -> Iterator[Problem]:
    for later, first in find_twins([hall.name for hall in study.hall]):
        name = study.hall[later].name
        yield Problem(("hall", later, "name"), name, f"hall {first} has this name already")
    if not study.hall:
        return
    from study.warehouse.layout import build_layout  # compiles kernels: only for halls of one's own

    for number, hall in enumerate(study.hall):
        try:
            build_layout(hall.spec)
        except LayoutError as error:
            problem = problem_of(error, hall)
            yield Problem(("hall", number, *problem.place), problem.value, problem.message)


@_reads("policy", "policy_sha256", "conditions", "practice")
def _check_policy(study: Study) -> Iterator[Problem]:
    key = "policy" if study.policy else "policy_sha256"
    named = study.policy or study.policy_sha256
    if named and "varil" not in (*study.conditions, study.practice.condition):
        yield Problem((key,), named, "no condition of this study follows a policy")


@_reads("endings", "panel")
def _check_endings(study: Study) -> Iterator[Problem]:
    for outcome in REQUIRED_OUTCOMES:
        if outcome not in study.endings:
            yield Problem(("endings", outcome), None, "this outcome needs a completion code")
    outcomes = list(study.endings)
    for later, first in find_twins([study.endings[outcome].code for outcome in outcomes]):
        code = study.endings[outcomes[later]].code
        place = ("endings", outcomes[later], "code")
        yield Problem(place, code, f"`{outcomes[first]}` has this code already; use one for each")
    for outcome, ending in study.endings.items():
        yield from _check_redirect(study, ("endings", outcome, "redirect"), ending)


def _check_redirect(study: Study, place: Place, ending: Any) -> Iterator[Problem]:
    if ending.host is not None and ending.host not in study.panel.hosts:
        hosts = ", ".join(study.panel.hosts) or "none yet"
        yield Problem(
            place,
            ending.redirect,
            f"the host {ending.host} is not in `panel.hosts` ({hosts})",
        )
    for blank in ending.blanks:
        if blank != "code" and blank not in study.panel.parameters:
            known = ", ".join(["code", *study.panel.parameters])
            yield Problem(place, ending.redirect, f"{{{blank}}} is unknown; there are: {known}")


@_reads("conditions", "texts")
def _check_elements(study: Study) -> Iterator[Problem]:
    names = [element.name for element in study.texts.elements]
    known = {name for shown in SHOWN.values() for name in shown.names}
    for later, _ in find_twins(names):
        place = ("texts", "elements", later, "name")
        yield Problem(place, names[later], "this element is explained already")
    for index, name in enumerate(names):
        if name not in known:
            allowed = f"there is no such element; use {', '.join(sorted(known))}"
            yield Problem(("texts", "elements", index, "name"), name, allowed)
    needed = {name for condition in study.conditions for name in SHOWN[condition].names}
    if lacking := sorted(needed - set(names)):
        yield Problem(("texts", "elements"), names, f"the text for {', '.join(lacking)} is missing")


@_reads("consent", "demographics", "questionnaire", "comments")
def _check_instruments(study: Study) -> Iterator[Problem]:
    named = list(_places_of_instruments(study))
    asked = [(place, instrument) for place, instrument in named if instrument.items]
    for later, first in find_twins([instrument.name for _, instrument in asked]):
        place, instrument = asked[later]
        message = f"{_show(asked[first][0])} has this name already; give it another `name`"
        yield Problem((*place, "name"), instrument.name, message)
    for place, instrument in named:
        if problem := scoring_problem(instrument):
            yield Problem((*place, "scoring"), instrument.scoring, problem)
        if not instrument.items and place[0] in ("consent", "questionnaire"):
            yield Problem((*place, "items"), None, "give at least one item, or name one by `use`")
        if instrument.items and not instrument.title:
            yield Problem((*place, "title"), "", "give a title")
    for step in ("questionnaire", "final"):
        yield from _check_page(study, step)


def _check_page(study: Study, step: str) -> Iterator[Problem]:
    """Items that stand on one page need names of their own there."""
    seen: set[str] = set()
    page = study.instruments(step)
    for place, instrument in _places_of_instruments(study):
        if not any(instrument is other for other in page):
            continue
        for index, item in enumerate(instrument.items):
            if item.name in seen:
                yield Problem(
                    (*place, "items", index, "name"),
                    item.name,
                    "another item on the same page has this name already",
                )
            seen.add(item.name)


@_reads("exclusion")
def _check_rules(study: Study) -> Iterator[Problem]:
    for later, first in find_twins([rule.name for rule in study.exclusion]):
        name = study.exclusion[later].name
        yield Problem(("exclusion", later, "name"), name, f"rule {first} has this name already")


@_reads("study_id", "title", "consent", "demographics", "questionnaire", "comments", "texts")
def _check_secrets(study: Study) -> Iterator[Problem]:
    """Participants must not learn what the conditions are called."""
    shown: dict[Place, Any] = {("study_id",): study.study_id, ("title",): study.title}
    shown |= {place: one.model_dump() for place, one in _places_of_instruments(study)}
    shown[("texts",)] = study.texts.model_dump()
    for place, value in shown.items():
        for where, text in _walk(value, place):
            if found := SECRET.search(text):
                message = f"participants would read “{found[0]}”, the name of a condition"
                yield Problem(where, text, message)


def _walk(value: Any, place: Place) -> Iterator[tuple[Place, str]]:
    if isinstance(value, str):
        yield place, value
    elif isinstance(value, dict):
        for key, inner in value.items():
            if key not in _UNSEEN:
                yield from _walk(inner, (*place, key))
    elif isinstance(value, list | tuple):
        for index, inner in enumerate(value):
            yield from _walk(inner, (*place, index))


def _places_of_instruments(study: Study) -> Iterator[tuple[Place, Any]]:
    yield ("consent",), study.consent
    yield ("demographics",), study.demographics
    for index, questionnaire in enumerate(study.questionnaire):
        yield ("questionnaire", index), questionnaire
    yield ("comments",), study.comments


def _show(place: Place) -> str:
    return f"{place[0]}[{place[1]}]" if len(place) > 1 else str(place[0])
