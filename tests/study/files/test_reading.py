"""Guards study files that are right: the demo's, the schema that describes them, the library."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from study.config import Study
from study.files.demo import demo_entries, demo_text, paper_study
from study.files.reading import read_study
from study.files.schema import PATTERNS, schema_text, study_schema
from study.protocol.instruments.library import NAMES, find_instrument
from study.protocol.questionnaires import Instrument

ROOT = Path(__file__).parent.parent.parent.parent


def changed(old: str, new: str) -> Study:
    """The demo's file with one change."""
    assert old in demo_text()
    return read_study(demo_text().replace(old, new, 1))


def test_the_demo_is_read_from_its_file() -> None:
    assert read_study(demo_text()) == paper_study()
    assert read_study("\ufeff" + demo_text().replace("\n", "\r\n")).plan == paper_study().plan


def test_every_comment_that_offers_keys_offers_right_ones() -> None:
    """What is commented out in the file that `varil init` writes can be switched on."""
    text = re.sub(r"(?m)^# (?=[a-z_0-9]+ = |\[\[)", "", demo_text())
    text = text.replace("hosts = []", 'hosts = ["app.prolific.com"]')
    study = read_study(text.replace('kind = "all" ', 'kind = "fixed" '))
    assert [one.name for one in study.questionnaire] == ["questionnaire", "nasa_tlx", "sus"]
    assert study.hall_spec("narrow").robots == 5
    assert study.exclusion[0].sentence == "hidden_s above 20 s (per trial)"
    assert study.policy == "policy.json"
    assert study.limits.trial_s == 1500
    assert study.endings["completed"].host == "app.prolific.com"
    assert "final" in study.plan.steps


def test_halls_may_differ_from_trial_to_trial() -> None:
    study = changed('scale = "study"', 'scale = ["small", "study", "lab"]')
    assert [study.scale_at(position) for position in (1, 2, 3)] == ["small", "study", "lab"]


def test_steps_on_which_nothing_is_asked_are_left_out() -> None:
    text = demo_text().replace('use = "demographics"', 'title = ""')
    text = text.replace('use = "comments"', "").replace('place = "each-trial"', 'place = "end"')
    assert read_study(text).plan.steps[-4:] == ("explanation-3", "trial-3", "final", "debrief")
    assert "demographics" not in read_study(text).plan.steps


def test_the_published_schema_is_the_one_in_force() -> None:
    """`make schema` writes it again."""
    assert (ROOT / "docs/study.schema.json").read_text(encoding="utf-8") == schema_text()


def test_the_schema_takes_what_is_read_and_refuses_what_is_not() -> None:
    validator = Draft202012Validator(study_schema())
    Draft202012Validator.check_schema(study_schema())
    assert list(validator.iter_errors(demo_entries())) == []
    wrong = dict(demo_entries()) | {"sede": 1, "seed": -1, "recruiting": "open"}
    assert len(list(validator.iter_errors(wrong))) == 3


def test_every_pattern_of_the_schema_has_words() -> None:
    patterns = set(re.findall(r'"pattern": "(.*)"', json.dumps(study_schema(), indent=0)))
    assert {pattern.replace("\\\\", "\\") for pattern in patterns} == set(PATTERNS)


@pytest.mark.parametrize("name", NAMES)
def test_an_instrument_of_the_library_is_whole_and_names_its_source(name: str) -> None:
    instrument = Instrument(use=name)
    assert instrument.items
    assert instrument.title
    assert instrument.source
    assert re.fullmatch(r"[a-z_]+", instrument.name)
    assert instrument == Instrument.model_validate(find_instrument(name) | {"use": name})


def test_what_a_study_says_of_an_instrument_goes_before_the_library() -> None:
    given = {"use": "nasa-tlx", "name": "tlx_end", "title": "Load", "random_order": True}
    instrument = Instrument.model_validate(given)
    assert (instrument.name, instrument.title, instrument.random_order) == ("tlx_end", "Load", True)
    assert len(instrument.items) == 6


def test_short_forms_of_options_and_inherited_ones() -> None:
    entries: dict[str, Any] = tomllib.loads(
        """
        name = "own"
        title = "Own"
        options = ["no", "perhaps", "yes"]
        [[items]]
        kind = "scale"
        name = "a"
        label = "?"
        [[items]]
        kind = "scale"
        name = "b"
        label = "?"
        options = ["never", "always"]
        [[items]]
        kind = "choice"
        name = "c"
        label = "?"
        options = ["Left hand", "Right hand", {value = "x", label = "Both"}]
        """
    )
    stored = [
        [option.value for option in getattr(item, "options", ())]
        for item in Instrument.model_validate(entries).items
    ]
    assert stored == [["1", "2", "3"], ["1", "2"], ["left_hand", "right_hand", "x"]]
