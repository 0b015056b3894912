"""Guards docs/study-files.md: it lists every key of a study file, and no other."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from study.files.schema import study_schema
from study.protocol.exclusions import MEASURES
from study.protocol.instruments.library import NAMES

TEXT = (Path(__file__).parent.parent / "docs/study-files.md").read_text(encoding="utf-8")
SECTIONS = {
    "Top level": "",
    "`[order]`": "OrderPlan",
    "`[practice]`": "TrialPlan",
    "`[[hall]]`": "Hall",
    "`[thresholds]`": "Thresholds",
    "`[display]`": "DisplaySettings",
    "`[limits]`": "Limits",
    "`[panel]`": "Panel",
    "`[endings.<outcome>]`": "Ending",
    "`[[questionnaire]]`, `[consent]`, `[demographics]`, `[comments]`": "Questionnaire",
    "`scale`": "ScaleItem",
    "`rating`": "RatingItem",
    "`slider`": "SliderItem",
    "`choice`": "ChoiceItem",
    "`number`": "NumberItem",
    "`text`": "TextItem",
    "`agree`": "AgreeItem",
    "`[[exclusion]]`": "ExclusionRule",
    "`[texts]`": "StudyTexts",
    "A page: `[texts.<page>]`": "PageText",
    "`[[texts.elements]]`": "ElementText",
}


def tables_below(heading: str) -> list[list[str]]:
    """First cells of each table below a heading."""
    (section,) = re.findall(
        rf"^#+ {re.escape(heading)}\n(.*?)(?=^#+ |\Z)", TEXT, re.MULTILINE | re.DOTALL
    )
    tables = re.findall(r"\| (\w.*?) \|.*\n\|---.*\n((?:\|.*\n)*)", section)
    return [re.findall(r"^\| `([\w-]+)` \|", rows, re.MULTILINE) for _, rows in tables]


def record(name: str) -> dict[str, Any]:
    """A record's part of the schema."""
    schema = study_schema()
    return dict(schema["$defs"][name] if name else schema)


@pytest.mark.parametrize("heading", SECTIONS)
def test_every_key_is_described_and_no_other(heading: str) -> None:
    keys = tables_below(heading)[0]
    described = record(SECTIONS[heading])["properties"]
    assert sorted(keys) == sorted(described)


@pytest.mark.parametrize("heading", SECTIONS)
def test_what_is_required_is_said_to_be(heading: str) -> None:
    for key in record(SECTIONS[heading]).get("required", ()):
        row = next(line for line in _rows(heading) if line.startswith(f"| `{key}` |"))
        assert "| required |" in row, row


def test_every_record_of_the_schema_has_its_section() -> None:
    apart = {"Instrument", "Option"}
    assert set(study_schema()["$defs"]) - apart == set(SECTIONS.values()) - {""}
    assert tables_below("`choice`")[1] == list(record("Option")["properties"])


def test_measures_and_instruments_are_listed() -> None:
    assert tables_below("`[[exclusion]]`")[1] == list(MEASURES)
    listed = tables_below("`[[questionnaire]]`, `[consent]`, `[demographics]`, `[comments]`")[1]
    assert sorted(listed) == sorted(NAMES)


def _rows(heading: str) -> list[str]:
    section = TEXT.split(f"# {heading}\n", 1)[1]
    return re.split(r"^#+ ", section, maxsplit=1, flags=re.MULTILINE)[0].splitlines()
