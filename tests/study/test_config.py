"""Guards the study record: one hash per meaning, and nothing incomplete gets through."""

from __future__ import annotations

from typing import get_args

import pytest
from pydantic import ValidationError

from study.ar.conditions import CONDITIONS
from study.config import Study
from study.protocol.displays import ConditionName


def test_the_demo_study_is_the_papers(study: Study) -> None:
    assert study.study_id == "demo"
    assert study.scale == ("study",)
    assert set(study.conditions) == {"varil", "arroch", "crmiar"}
    assert (study.practice.condition, study.practice.tries) == ("none", 3)
    assert len(study.orders) == 6


def test_a_study_survives_its_own_json_with_the_same_hash(study: Study) -> None:
    again = Study.model_validate_json(study.canonical_json)
    assert again == study
    assert again.config_hash == study.config_hash


def test_any_change_changes_the_hash(study: Study) -> None:
    changed = [study.revised(seed=study.seed + 1), study.revised(scale="small")]
    changed.append(study.revised(thresholds={"close_m": 4.0}))
    assert len({study.config_hash, *(other.config_hash for other in changed)}) == 4


def test_names_in_a_study_are_the_names_that_exist() -> None:
    assert set(get_args(ConditionName)) == set(CONDITIONS)


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"conditions": ("varil", "varil")}, "twice"),
        ({"conditions": ("magic",)}, "conditions"),
        ({"endings": {"completed": {"code": "DONE-1"}}}, "screened-out"),
        ({"study_id": "../etc"}, "study_id"),
        ({"limits": {"time_scale": 9.0}}, "limits.time_scale"),
        ({"practice": {"tries": 0}}, "practice.tries"),
        ({"stranger": 1}, "stranger"),
    ],
)
def test_a_wrong_study_names_the_place(study: Study, change: dict[str, object], place: str) -> None:
    with pytest.raises(ValidationError, match=place):
        study.revised(**change)


def test_an_element_without_a_text_is_refused(study: Study) -> None:
    texts = study.texts.model_copy(update={"elements": study.texts.elements[1:]})
    with pytest.raises(ValidationError, match="trajectory"):
        study.revised(texts=texts.model_dump())


def test_a_study_is_frozen(study: Study) -> None:
    with pytest.raises(ValidationError):
        study.seed = 1  # type: ignore[misc]
