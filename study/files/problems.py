"""Validation errors as problems a person can mend: the place in the file, the value, a sentence.

The sentences say what is allowed at the place; the schema is asked for it.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from study.config import Study
from study.files.schema import describe_allowed, known_keys
from study.protocol.records import Place, Problem

_WORDS = (
    (bool, "true or false"),
    (int, "a whole number"),
    (float, "a number"),
    (str, "text"),
    (list, "a list"),
    (dict, "a table"),
)
_UNION_TAGS = ("union_tag_invalid", "union_tag_not_found")


def explain_errors(error: ValidationError, entries: Mapping[str, Any]) -> list[Problem]:
    """Every error as a problem, in the order of the file's keys."""
    problems = [
        problem
        for detail in error.errors(include_url=False)
        for problem in _explain(detail, entries)
    ]
    order = list(Study.model_fields)
    return sorted(problems, key=lambda one: _rank(order, one.place))


def find_mixed_instruments(entries: Mapping[str, Any]) -> list[Problem]:
    """Instruments that take items of the library and bring their own: which count is unclear."""
    message = "give either `use` or `items`: the items of the library are taken as they are"
    return [
        Problem((*place, "items"), None, message)
        for place, instrument in _instruments_in(entries)
        if isinstance(instrument, Mapping) and instrument.get("use") and "items" in instrument
    ]


def _instruments_in(entries: Mapping[str, Any]) -> Iterator[tuple[Place, Any]]:
    for key in ("consent", "demographics", "comments"):
        yield (key,), entries.get(key)
    listed = entries.get("questionnaire")
    for index, instrument in enumerate(listed if isinstance(listed, list) else ()):
        yield ("questionnaire", index), instrument


def _rank(order: Sequence[str], place: Place) -> int:
    return order.index(str(place[0])) if place and place[0] in order else len(order)


def _explain(detail: ErrorDetails, entries: Mapping[str, Any]) -> list[Problem]:
    place, value = _locate(detail, entries)
    context = detail.get("ctx", {})
    kind = detail["type"]
    if kind == "study_problems":
        return [
            Problem((*place, *inner.place), inner.value, inner.message)
            for inner in context["problems"]
        ]
    if kind == "refused_below":
        key = (context["key"],) if context["key"] else ()
        return [Problem((*place, *key), value, context["reason"])]
    if kind in ("extra_forbidden", "unexpected_keyword_argument"):
        return [Problem(place, value, _explain_stranger(place))]
    if kind in _UNION_TAGS:
        kinds = "use one of: scale, rating, slider, choice, number, text, agree"
        return [Problem((*place, "kind"), _value_at(value, "kind"), f"unknown kind; {kinds}")]
    return [Problem(place, value, _sentence(detail, place, value))]


def _sentence(detail: ErrorDetails, place: Place, value: Any) -> str:
    allowed = describe_allowed(place)
    kind = detail["type"]
    if detail["loc"][-1] == "[key]":
        return f"there is no such key; known here: {detail['ctx']['expected']}"
    if kind == "missing":
        return f"this key is missing; give {allowed}" if allowed else "this key is missing"
    if kind in ("value_error",):
        return detail["msg"].removeprefix("Value error, ")
    if kind.endswith(("_type", "_parsing")) or kind in ("int_from_float", "finite_number"):
        return f"{_name_kind(value)} stands here; give {allowed}"
    return f"not allowed here; give {allowed}" if allowed else detail["msg"]


def _explain_stranger(place: Place) -> str:
    known = known_keys(place[:-1])
    close = difflib.get_close_matches(str(place[-1]), known, n=1, cutoff=0.6)
    if close:
        return f"there is no such key; did you mean `{close[0]}`?"
    return f"there is no such key; known here: {', '.join(known)}"


def _locate(detail: ErrorDetails, entries: Mapping[str, Any]) -> tuple[Place, Any]:
    """The place in the file and what stands there: parts that only pydantic knows are left out."""
    place: list[str | int] = []
    here: Any = entries
    for part in detail["loc"]:
        if isinstance(here, Mapping) and part in here:
            place.append(part)
            here = here[str(part)]
        elif isinstance(here, list) and isinstance(part, int) and part < len(here):
            place.append(part)
            here = here[part]
    if detail["type"] == "missing":
        return (*place, detail["loc"][-1]), None
    return tuple(place), here


def _value_at(value: Any, key: str) -> Any:
    return value.get(key) if isinstance(value, Mapping) else value


def _name_kind(value: Any) -> str:
    """What kind of TOML value this is."""
    return next((word for kind, word in _WORDS if isinstance(value, kind)), "a date or time")
