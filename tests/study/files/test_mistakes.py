"""Guards what is said about wrong study files: each mistake with its place and its sentence."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from study.errors import StudyFileError
from study.files.demo import demo_text
from study.files.reading import read_study
from study.protocol.records import show_place

TABLE = tomllib.loads((Path(__file__).parent / "mistakes.toml").read_text(encoding="utf-8"))
MISTAKES = {entry["what"]: entry for entry in TABLE["mistake"]}


def problems_of(text: str) -> dict[str, str]:
    """Sentences by place."""
    with pytest.raises(StudyFileError) as caught:
        read_study(text)
    return {show_place(problem.place): problem.message for problem in caught.value.problems}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_named_with_its_place_and_what_is_allowed(name: str) -> None:
    mistake = MISTAKES[name]
    assert mistake["replace"] in demo_text(), "the demo's file has changed; mend this table"
    found = problems_of(demo_text().replace(mistake["replace"], mistake["by"], 1))
    assert mistake["place"] in found, found
    assert mistake["says"] in found[mistake["place"]]


def test_there_are_mistakes_enough() -> None:
    assert len(MISTAKES) == len(TABLE["mistake"]) >= 40


def test_all_mistakes_are_told_at_once_also_of_parts_that_must_agree() -> None:
    text = demo_text().replace("tries = 3", "tries = 0").replace("ROBOTS-3TRY", "ROBOTS-7K2M")
    text = text.replace("[display]", "[dispaly]").replace('name = "balloon"', 'name = "minimap"')
    assert set(problems_of(text)) == {
        "practice.tries",
        "dispaly",
        "endings.screened-out.code",
        "texts.elements",
        "texts.elements[4].name",
    }


def test_an_empty_file_lacks_every_key_that_a_study_needs() -> None:
    assert {"study_id", "title", "seed", "conditions", "consent", "endings", "texts"} <= set(
        problems_of("")
    )


@pytest.mark.parametrize("text", ["[" * 5000, "a = " + "[" * 5000, "x = 1\n" * 300_000, "\x00"])
def test_hostile_files_are_refused_like_any_other(text: str) -> None:
    assert "" in problems_of(text)
