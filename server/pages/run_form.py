"""The form that starts a learning run: its fields, and what somebody typed as a request."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, get_args

from server.desks.learning import RunRequest
from server.store.learning import WorkerKind
from study.errors import AnswerError, InvalidValue
from study.learning.classifiers import CLASSIFIERS
from study.learning.settings import (
    BOX_MODES,
    LABEL_SOURCES,
    LARGEST_SEED,
    MOST_ITERATIONS,
    PAIR_UNITS,
    PAIRS_PER_ITERATION,
    LearningSettings,
)
from study.warehouse.halls import PRESETS

LONGEST_SHOWN = 60


@dataclass(frozen=True)
class FormField:
    """One field: `options` are (value, label) of a choice, or values that a text suggests."""

    name: str
    label: str
    help: str
    kind: Literal["choice", "number", "text"]
    options: tuple[tuple[str, str], ...] = ()


def _choice(name: str, label: str, help_: str, labels: Mapping[str, str]) -> FormField:
    return FormField(name, label, help_, "choice", tuple(labels.items()))


_SCALES = {
    name: f"{name}: {spec.robots} robot{'s' if spec.robots > 1 else ''}"
    for name, spec in PRESETS.items()
}
FIELDS = (
    _choice("scale", "Hall", "Where the team works; the run keeps it.", _SCALES),
    _choice(
        "worker",
        "Worker",
        "Who carries on the work that the expert watches.",
        {
            "person": "a person, with a link",
            "simulated": "simulated",
        },
    ),
    FormField(
        "iterations",
        "Iterations",
        f"1 to {MOST_ITERATIONS}, of {PAIRS_PER_ITERATION} pairs each; the paper has 240.",
        "number",
    ),
    FormField("seed", "Seed", f"0 to {LARGEST_SEED}; fixes worlds and draws.", "number"),
)
FURTHER_FIELDS = (
    _choice(
        "box_mode",
        "Boxes",
        "What a box does when the policy's proposal changes: take it, or keep the expert's.",
        {
            "follow": "follow: takes proposals",
            "independent": "independent: keeps settings",
        },
    ),
    _choice(
        "label_source",
        "Labels",
        "Which agents give a pair at a snapshot.",
        {
            "boxes": "boxes: every agent",
            "events": "events: those edited in the last 8 s",
            "confirmed": "confirmed: those edited or marked right in the last 8 s",
        },
    ),
    _choice(
        "pair_unit",
        "Unit of a pair",
        f"What counts as one of the {PAIRS_PER_ITERATION} of an iteration.",
        {"agent": "agent: one agent's pair", "snapshot": "snapshot: all agents at once"},
    ),
    FormField(
        "beta",
        "Beta",
        "How often the expert's boxes are displayed rather than the policy's choice: linear, "
        "first_only, or exponential(p) with p from 0 to 1.",
        "text",
        (("linear", ""), ("first_only", ""), ("exponential(0.95)", "")),
    ),
    _choice(
        "classifier",
        "Classifier",
        "What is trained after each iteration.",
        {
            "svm": "svm: all elements at once",
            "per_element": "per_element: one for each",
            "majority": "majority: commonest action",
            "cost_sensitive": "cost_sensitive: by differences",
        },
    ),
)
ALL_FIELDS = (*FIELDS, *FURTHER_FIELDS)
LABELS: Mapping[str, str] = MappingProxyType({field.name: field.label for field in ALL_FIELDS})
_CHOICES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "scale": tuple(PRESETS),
        "worker": get_args(WorkerKind),
        "box_mode": BOX_MODES,
        "label_source": LABEL_SOURCES,
        "pair_unit": PAIR_UNITS,
        "classifier": tuple(CLASSIFIERS),
    }
)


def fresh_values() -> dict[str, str]:
    """What the empty form shows: the paper's settings, and a seed nobody chose."""
    usual = {name: str(value) for name, value in LearningSettings().to_json().items()}
    seed = str(secrets.randbelow(1_000_000))
    return usual | {"scale": "study", "worker": "person", "seed": seed}


def read_run_form(form: Mapping[str, str]) -> RunRequest:
    """The request in a sent form; AnswerError with a sentence for each field that is wrong."""
    typed = {field.name: form.get(field.name, "").strip() for field in ALL_FIELDS}
    problems = {
        name: f"Choose one of: {', '.join(allowed)}."
        for name, allowed in _CHOICES.items()
        if typed[name] not in allowed
    }
    numbers = {}
    for name in ("iterations", "seed"):
        number = _whole_number(typed[name])
        if number is None:
            problems[name] = "Give a whole number in digits."
        else:
            numbers[name] = number
    problems |= {
        name: _problem(name, value)
        for name, value in (numbers | {"beta": typed["beta"]}).items()
        if _problem(name, value)
    }
    if problems:
        raise AnswerError({name: problems[name] for name in LABELS if name in problems})
    return RunRequest(
        scale=typed["scale"],
        worker="person" if typed["worker"] == "person" else "simulated",
        settings=LearningSettings(
            iterations=numbers["iterations"],
            seed=numbers["seed"],
            beta=typed["beta"],
            box_mode=typed["box_mode"],
            label_source=typed["label_source"],
            pair_unit=typed["pair_unit"],
            classifier=typed["classifier"],
        ),
    )


def _whole_number(text: str) -> int | None:
    fits = text.isascii() and text.isdigit() and len(text) <= LONGEST_SHOWN
    return int(text) if fits else None


def _problem(name: str, value: object) -> str:
    """What the settings themselves say against a value; nothing if it is allowed."""
    try:
        LearningSettings(**{name: value})  # type: ignore[arg-type]
    except InvalidValue as error:
        return error.next_step
    return ""
