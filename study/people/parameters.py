"""The simulated people's parameters, read from the one versioned file beside this module."""

from __future__ import annotations

import functools
import math
import tomllib
from collections.abc import Mapping
from importlib import resources
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from study.errors import InvalidValue

FILE = "parameters.toml"


@functools.cache
def parameter_text() -> str:
    """The file's text, comments and sources included."""
    return resources.files("study.people").joinpath(FILE).read_text(encoding="utf-8")


@functools.cache
def parameters_of(person: str) -> Mapping[str, float]:
    """The values of a person's parameters by name: seconds, metres and degrees as named."""
    return MappingProxyType(read_parameters(parameter_text(), person))


@functools.cache
def limits_of(name: str) -> tuple[float, float]:
    """The least and the most that a parameter may be, as "worker.notice": 0 and inf if unnamed.

    Errors: InvalidValue for a parameter that does not exist.
    """
    person, _, parameter = name.partition(".")
    found = tomllib.loads(parameter_text()).get(person, {})
    if not isinstance(found, dict) or parameter not in found:
        raise InvalidValue(
            f"there is no parameter “{name[:60]}”",
            where="replaced",
            next_step=f"Use a name from {FILE}, such as worker.decide_s.",
        )
    return float(found[parameter].get("least", 0.0)), float(found[parameter].get("most", math.inf))


def parameter_version() -> int:
    """The version of the file, stored with what was made by it."""
    return int(tomllib.loads(parameter_text())["version"])


def read_parameters(text: str, person: str) -> dict[str, float]:
    """The values in a file's text. Errors: InvalidValue where a value or its origin is missing."""
    values = {}
    for name, entry in tomllib.loads(text).get(person, {}).items():
        where = f"{FILE}, {person}.{name}"
        if not isinstance(entry.get("value"), int | float) or entry["value"] < 0:
            raise InvalidValue("a value of at least 0 is missing", where=where)
        if not entry.get("source") and not entry.get("reason"):
            raise InvalidValue(
                "it says neither source nor reason", where=where, next_step="Add one of the two."
            )
        values[name] = float(entry["value"])
    if not values:
        raise InvalidValue(f"there are no parameters of “{person[:40]}”", where=FILE)
    return values


def as_record(values: Mapping[str, float]) -> npt.NDArray[np.void]:
    """The values as one row of a structured array, for compiled code."""
    record = np.zeros(1, dtype=[(name, "f8") for name in values])
    for name, value in values.items():
        record[name] = value
    return record
