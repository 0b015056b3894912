"""The JSON Schema of study files, and what it allows at a place.

Published as `docs/study.schema.json` and served at `/study.schema.json`; editors that know TOML
complete and check keys with it.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Iterator, Mapping
from typing import Any

from study.config import Study
from study.protocol.instruments.library import NAMES
from study.protocol.records import Place

DIALECT = "https://json-schema.org/draft/2020-12/schema"
PATTERNS = {
    r"^[a-z][a-z0-9-]{0,39}$": "lower-case letters, digits and hyphens, at most 40, a letter first",
    r"^[A-Za-z][A-Za-z0-9_]{0,39}$": "letters, digits and underscores, at most 40, a letter first",
    r"^[A-Za-z0-9-]{4,40}$": "4 to 40 letters, digits and hyphens",
    r"^([0-9a-f]{64})?$": "64 hexadecimal digits",
    r"^([a-z0-9]([a-z0-9-]{0,61}[a-z0-9])?\.)+[a-z]{2,63}$": (
        "a host name in lower case, as in app.prolific.com, without https:// and path"
    ),
}
"""What each pattern of the schema means in words."""


@functools.cache
def study_schema() -> dict[str, Any]:
    """The schema as plain JSON values."""
    schema = Study.model_json_schema(mode="validation")
    for name in ("Instrument", "Questionnaire"):
        use = schema["$defs"][name]["properties"]["use"]
        use["enum"] = ["", *NAMES]
    return {"$schema": DIALECT, **schema, "title": "A study file of VARIL"}


def schema_text() -> str:
    """The schema as it is published."""
    return json.dumps(study_schema(), indent=2, ensure_ascii=False) + "\n"


def known_keys(place: Place) -> list[str]:
    """The keys that the record at a place may have, in the schema's order."""
    keys: dict[str, None] = {}
    for node in _nodes_at(place):
        keys |= dict.fromkeys(node.get("properties", {}))
    return list(keys)


def describe_allowed(place: Place) -> str:
    """In words what may stand at a place, or an empty text where the schema does not tell."""
    words = [text for node in _nodes_at(place) if (text := _describe(node))]
    return " or ".join(dict.fromkeys(words))


def _nodes_at(place: Place) -> list[Mapping[str, Any]]:
    """The parts of the schema that apply at a place; several where there are alternatives."""
    nodes = list(_spread(study_schema()))
    for part in place:
        nodes = [deeper for node in nodes for deeper in _step_down(node, part)]
    return nodes


def _step_down(node: Mapping[str, Any], part: str | int) -> Iterator[Mapping[str, Any]]:
    if isinstance(part, int):
        if isinstance(node.get("items"), Mapping):
            yield from _spread(node["items"])
    elif part in node.get("properties", {}):
        yield from _spread(node["properties"][part])
    elif isinstance(node.get("additionalProperties"), Mapping):
        yield from _spread(node["additionalProperties"])


def _spread(node: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """A node with references followed and alternatives one by one."""
    if "$ref" in node:
        name = node["$ref"].rsplit("/", 1)[1]
        yield from _spread(study_schema()["$defs"][name])
        return
    for key in ("anyOf", "oneOf", "allOf"):
        if key in node:
            for alternative in node[key]:
                yield from _spread(alternative)
            return
    yield node


def _describe(node: Mapping[str, Any]) -> str:
    if "const" in node:
        return _word(node["const"])
    if "enum" in node:
        return "one of: " + ", ".join(_word(value) for value in node["enum"] if value != "")
    kind = node.get("type")
    if kind == "string":
        return _describe_text(node)
    if kind in ("integer", "number"):
        return _describe_number(node)
    if kind == "object":
        needed = ", ".join(f"`{key}`" for key in node.get("required", ()))
        return f"a table with {needed}" if needed else "a table"
    if kind == "array":
        return _describe_list(node)
    return "true or false" if kind == "boolean" else ""


def _describe_text(node: Mapping[str, Any]) -> str:
    if node.get("pattern") in PATTERNS:
        return PATTERNS[node["pattern"]]
    shortest, longest = node.get("minLength", 0), node.get("maxLength")
    if longest is not None:
        return (
            f"text of {shortest} to {longest} characters"
            if shortest
            else (f"text of at most {longest} characters")
        )
    return "text"


def _describe_number(node: Mapping[str, Any]) -> str:
    what = "a whole number" if node["type"] == "integer" else "a number"
    low, high = node.get("minimum"), node.get("maximum")
    if "exclusiveMaximum" in node:
        high = node["exclusiveMaximum"] - 1
    if low is not None and high is not None:
        return f"{what} from {_plain(low)} to {_plain(high)}"
    if low is not None:
        return f"{what} of at least {_plain(low)}"
    return f"{what} of at most {_plain(high)}" if high is not None else what


def _plain(figure: float) -> str:
    return str(int(figure)) if figure == int(figure) else str(figure)


def _describe_list(node: Mapping[str, Any]) -> str:
    fewest, most = node.get("minItems", 0), node.get("maxItems")
    if most is not None:
        return f"a list of {fewest} to {most} entries"
    return f"a list of at least {fewest} entries" if fewest else "a list"


def _word(value: Any) -> str:
    return f"`{value}`" if isinstance(value, str) else str(value)
