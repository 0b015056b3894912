"""The base of every record of a study, and how a record says what is wrong with it.

Checks that look at several fields report all they find at once: `refuse` raises one error that
carries a list of `Problem`, each with its place below the record.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ConfigDict
from pydantic_core import PydanticCustomError

NAME_PATTERN = r"^[A-Za-z][A-Za-z0-9_]{0,39}$"
Place = tuple[str | int, ...]


class Record(BaseModel):
    """Base of every record of a study file: frozen, and strangers are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


@dataclass(frozen=True)
class Problem:
    """What is wrong at a place: the keys and indices that lead there, the value, and a sentence."""

    place: Place
    value: Any
    message: str


def refuse(problems: Sequence[Problem]) -> None:
    """Raise a validation error that carries these problems; nothing happens without any."""
    if problems:
        sentences = "; ".join(f"{show_place(p.place)}: {p.message}" for p in problems)
        raise PydanticCustomError(
            "study_problems", "{sentences}", {"sentences": sentences, "problems": list(problems)}
        )


def show_place(place: Place) -> str:
    """The place as it is written in errors: `questionnaire[0].items[2].label`."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def find_twins(values: Sequence[str]) -> list[tuple[int, int]]:
    """Pairs (later, first) of indices at which a value stands again."""
    first: dict[str, int] = {}
    return [
        (index, first[value])
        for index, value in enumerate(values)
        if first.setdefault(value, index) != index
    ]
