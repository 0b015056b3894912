"""A visualization policy: two lookup tables, the borders of their states, and where they come from.

A policy file is JSON without time, host or path. Its tables name every state, so a missing one
can be named; its `sha256` is taken over everything else in it, in canonical form (keys sorted, no
spaces), so that a changed file is noticed. Reading is strict: anything missing, unknown, off the
scale or not finite is a PolicyError that names the place.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NoReturn, cast

from study.ar.elements import ROBOT_ACTIONS, STATION_ACTIONS
from study.ar.state_names import ROBOT_STATES, STATION_STATES
from study.ar.thresholds import Thresholds
from study.errors import PolicyError

SCHEMA = "varil-policy"
SCHEMA_VERSION = 1
Origin = Literal["initial", "control", "people", "simulated"]
ORIGINS: tuple[Origin, ...] = ("initial", "control", "people", "simulated")
TRAINING_FIELDS = ("data_sha256", "settings", "seed", "scores", "libraries")
LONGEST_NAME = 120
LONGEST_SHOWN = 80

_FIELDS = (
    "schema",
    "schema_version",
    "name",
    "origin",
    "thresholds",
    "robot_table",
    "station_table",
    "training",
    "sha256",
)
_HASH = re.compile(r"[0-9a-f]{64}")
_REPAIR = "Take the file again from where it was made; it must not be edited by hand."


@dataclass(frozen=True)
class Policy:
    """One policy. Tables hold actions by state number; see `study.ar.state_names` for the order.

    A robot's action is the sum of 1 live location, 2 transparent avatar, 4 trajectory; a
    station's is 1 for the balloon. `training` is None for a policy nobody taught, else it has
    data_sha256 (hash of the training data), settings, seed, scores and libraries (versions).
    """

    name: str
    origin: Origin
    thresholds: Thresholds
    robot_table: tuple[int, ...]
    station_table: tuple[int, ...]
    training: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        _check_table("robot_table", self.robot_table, len(ROBOT_STATES), ROBOT_ACTIONS)
        _check_table("station_table", self.station_table, len(STATION_STATES), STATION_ACTIONS)
        if self.origin not in ORIGINS:
            what = f"{_shown(self.origin)} is not known"
            _refuse("origin", what, f"Use one of {', '.join(ORIGINS)}.")
        if not 0 < len(self.name) <= LONGEST_NAME or not self.name.isprintable():
            what = f"{_shown(self.name)} cannot be a policy's name"
            _refuse("name", what, f"Use 1 to {LONGEST_NAME} printable characters.")
        if self.training is not None:
            _check_training(self.training)

    @property
    def sha256(self) -> str:
        """Hash over the canonical form of everything in the policy."""
        return hashlib.sha256(_canonical(self._body())).hexdigest()

    def to_json(self) -> str:
        """The policy file's text; writing the same policy twice gives the same bytes."""
        record = {**self._body(), "sha256": self.sha256}
        return json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"

    def require_thresholds(self, wanted: Thresholds) -> None:
        """Raise PolicyError naming each border on which the policy and a study differ."""
        mine, theirs = self.thresholds.to_json(), wanted.to_json()
        differing = [f"{k} {mine[k]} (study: {theirs[k]})" for k in mine if mine[k] != theirs[k]]
        if differing:
            _refuse(
                "thresholds",
                f"the policy “{self.name}” was made for other state borders: "
                + ", ".join(differing),
                "Use a policy learned with the study's thresholds, or change the study's.",
            )

    def _body(self) -> dict[str, Any]:
        return {
            "schema": SCHEMA,
            "schema_version": SCHEMA_VERSION,
            "name": self.name,
            "origin": self.origin,
            "thresholds": self.thresholds.to_json(),
            "robot_table": dict(zip(ROBOT_STATES, self.robot_table, strict=True)),
            "station_table": dict(zip(STATION_STATES, self.station_table, strict=True)),
            "training": self.training,
        }


def initial_policy(thresholds: Thresholds | None = None) -> Policy:
    """The policy before anything was learned: everything on [paper]."""
    return Policy(
        name="initial",
        origin="initial",
        thresholds=thresholds or Thresholds(),
        robot_table=(ROBOT_ACTIONS - 1,) * len(ROBOT_STATES),
        station_table=(STATION_ACTIONS - 1,) * len(STATION_STATES),
    )


def read_policy(text: str | bytes) -> Policy:
    """The policy in a policy file's text; PolicyError names what is wrong and where."""
    try:
        record = json.loads(text, parse_constant=_refuse_constant, object_pairs_hook=_unique)
    except (ValueError, RecursionError) as problem:
        _refuse("policy file", f"this is no JSON ({problem})", _REPAIR)
    if not isinstance(record, dict):
        _refuse("policy file", "one JSON object was expected", _REPAIR)
    _check_schema(record)
    _check_fields("policy file", record, _FIELDS)
    policy = Policy(
        name=_text(record, "name"),
        origin=cast(Origin, _text(record, "origin")),
        thresholds=Thresholds.from_json(record["thresholds"]),
        robot_table=_read_table(record, "robot_table", ROBOT_STATES),
        station_table=_read_table(record, "station_table", STATION_STATES),
        training=record["training"],
    )
    if policy.sha256 != record["sha256"]:
        said = _shown(record["sha256"])
        _refuse("sha256", f"the file says {said}, its contents give {policy.sha256}", _REPAIR)
    return policy


def _check_schema(record: Mapping[str, Any]) -> None:
    found = (record.get("schema"), record.get("schema_version"))
    if found != (SCHEMA, SCHEMA_VERSION) or type(found[1]) is not int:
        _refuse(
            "schema",
            f"this is {_shown(found[0])} version {_shown(found[1])}, wanted {SCHEMA!r} version"
            f" {SCHEMA_VERSION}",
            "Learn the policy again with this version of the software.",
        )


def _read_table(record: Mapping[str, Any], name: str, states: Sequence[str]) -> tuple[int, ...]:
    table = record[name]
    if not isinstance(table, dict):
        _refuse(name, "an object with an action for each state was expected", _REPAIR)
    _check_fields(name, table, states)
    return tuple(table[state] for state in states)


def _check_table(name: str, table: Sequence[object], states: int, actions: int) -> None:
    if len(table) != states:
        _refuse(name, f"there are {len(table)} actions, wanted {states}", _REPAIR)
    names = ROBOT_STATES if states == len(ROBOT_STATES) else STATION_STATES
    for state, action in zip(names, table, strict=True):
        if type(action) is not int or not 0 <= action < actions:
            _refuse(
                f"{name}, {state}",
                f"the action {_shown(action)} is not allowed",
                f"Actions are whole numbers from 0 to {actions - 1}.",
            )


def _check_training(training: object) -> None:
    """Refuse what no run of PolicyUp writes, so that whoever shows it need not ask again."""
    _check_fields("training", training, TRAINING_FIELDS)
    record = cast("Mapping[str, Any]", training)
    if not isinstance(record["data_sha256"], str) or not _HASH.fullmatch(record["data_sha256"]):
        what = f"{_shown(record['data_sha256'])} is no SHA-256 in hexadecimal digits"
        _refuse("training, data_sha256", what, _REPAIR)
    if type(record["seed"]) is not int or record["seed"] < 0:
        _refuse("training, seed", f"{_shown(record['seed'])} is no seed", _REPAIR)
    for part, kinds in (("settings", (object,)), ("scores", (int, float)), ("libraries", (str,))):
        if not isinstance(record[part], Mapping):
            what = f"an object was expected, not {_shown(record[part])}"
            _refuse(f"training, {part}", what, _REPAIR)
        for name, value in record[part].items():
            if not isinstance(value, kinds):
                what = f"{_shown(value)} is not allowed for “{str(name)[:60]}”"
                _refuse(f"training, {part}", what, _REPAIR)
    try:
        json.dumps(training, ensure_ascii=False).encode()
    except (TypeError, ValueError):
        _refuse("training", "it holds something that no file can hold", _REPAIR)


def _check_fields(where: str, record: object, wanted: Sequence[str]) -> None:
    if not isinstance(record, Mapping):
        _refuse(where, f"an object was expected, not {_shown(record)}", _REPAIR)
    known = set(wanted)
    missing = [name for name in wanted if name not in record]
    unknown = [name for name in record if name not in known]
    if missing:
        _refuse(where, f"{_listing(missing)} missing", _REPAIR)
    if unknown:
        _refuse(where, f"{_listing(unknown)} not known", _REPAIR)


def _listing(names: Sequence[str]) -> str:
    shown = ", ".join(f"“{str(name)[:60]}”" for name in names[:3])
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return f"{shown}{more} {'is' if len(names) == 1 else 'are'}"


def _text(record: Mapping[str, Any], name: str) -> str:
    value = record[name]
    if not isinstance(value, str) or not value:
        _refuse(name, f"a text was expected, not {_shown(value)}", _REPAIR)
    return value


def _shown(value: object) -> str:
    """A value as a sentence can bear it."""
    text = repr(value)
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    record: dict[str, Any] = {}
    for name, value in pairs:
        if name in record:
            _refuse("policy file", f"“{name[:60]}” is given twice", _REPAIR)
        record[name] = value
    return record


def _refuse_constant(word: str) -> float:
    _refuse("policy file", f"{word} is no number a policy may hold", _REPAIR)


def _canonical(body: Mapping[str, Any]) -> bytes:
    try:
        text = json.dumps(body, sort_keys=True, separators=(",", ":"), allow_nan=False)
    except ValueError:
        _refuse("training", "a number in it is not finite", _REPAIR)
    return text.encode()


def _refuse(where: str, what: str, next_step: str) -> NoReturn:
    raise PolicyError(what, where=where, next_step=next_step)
