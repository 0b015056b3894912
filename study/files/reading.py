"""A study file's text becomes a `Study`, or an error that lists everything that is wrong with it.

First TOML, then every key against the records, then what must agree between the parts. Checks of
the last kind still run beside wrong entries as long as they do not read them.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Mapping
from typing import Any

from pydantic import ValidationError

from study.config import Study
from study.errors import StudyFileError
from study.files.demo import demo_entries
from study.files.problems import explain_errors, find_mixed_instruments
from study.protocol.records import Problem

LONGEST_CHARACTERS = 1_000_000
Entries = Mapping[str, Any]


def read_study(text: str, where: str = "") -> Study:
    """The study in a file's text. Errors: StudyFileError with every problem found."""
    entries = read_toml(text, where)
    problems = find_mixed_instruments(entries)
    try:
        study = validate_entries(entries)
    except ValidationError as error:
        problems = problems + explain_errors(error, entries)
        unsound = {str(problem.place[0]) for problem in problems if problem.place}
        problems += check_the_rest(entries, unsound)
        raise StudyFileError(problems, where) from error
    if problems:
        raise StudyFileError(problems, where)
    return study


def read_toml(text: str, where: str = "") -> dict[str, Any]:
    """The entries of a file. Errors: StudyFileError with the line at which TOML was broken."""
    if len(text) > LONGEST_CHARACTERS:
        message = f"the file has more than {LONGEST_CHARACTERS} characters"
        raise StudyFileError([Problem((), len(text), message)], where)
    try:
        return tomllib.loads(text.removeprefix("\ufeff"))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        message = f"this is not TOML: {str(error) or 'it is nested too deeply'}"
        raise StudyFileError([Problem((), None, message)], where) from error


def validate_entries(entries: Entries, unsound: Collection[str] = ()) -> Study:
    """The record of these entries, with numbers, texts and switches taken strictly.

    Checks that read one of the `unsound` keys are left out.
    """
    text = json.dumps(entries, default=str)
    return Study.model_validate_json(text, strict=True, context={"unsound": unsound})


def check_the_rest(entries: Entries, unsound: Collection[str]) -> list[Problem]:
    """What does not agree among the keys that are sound by themselves."""
    standing_in = {key: value for key, value in demo_entries().items() if key in unsound}
    sound = {
        key: value
        for key, value in entries.items()
        if key in Study.model_fields and key not in unsound
    }
    try:
        validate_entries(sound | standing_in, unsound)
    except ValidationError as error:
        return explain_errors(error, sound | standing_in)
    return []
