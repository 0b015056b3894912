"""Guards the launch checklist: every point turns by its own cause, and says why."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from study.config import Study
from study.protocol.checklist import Point, Surroundings, check_launch

RULE = {"name": "hidden", "measure": "hidden_s", "per": "trial", "above": 30.0}
READY = Surroundings(tried=24, policy_origin="people", time_scale=1.0, is_https=True)


def points(study: Study, around: Surroundings = READY) -> dict[str, Point]:
    found = check_launch(study, around)
    assert len({point.title for point in found}) == len(found)
    assert all(point.detail for point in found)
    return {point.title: point for point in found}


def launched(study: Study, **changes: Any) -> Study:
    return study.revised(**{"recruiting": "live", "exclusion": (RULE,), **changes})


def test_a_study_that_is_ready_has_nothing_red(study: Study) -> None:
    """Only the texts stay open: no program can say that they were read."""
    found = points(launched(study))
    assert {title for title, point in found.items() if point.state != "done"} == {"Texts"}
    assert found["Texts"].state == "open"
    assert study.texts.contact in found["Texts"].detail
    assert found["Sample size"].detail == "24, 4 per order"
    assert found["Exclusion rules"].detail == "hidden_s above 30 s (per trial)"
    assert found["Consent"].detail == f"{len(study.consent.items)} statements must be agreed to"


@pytest.mark.parametrize(
    ("title", "changes", "state", "told"),
    [
        ("Sample size", {"planned_participants": None}, "problem", "planned_participants"),
        ("Sample size", {"planned_participants": 25}, "open", "do not fill 6 orders evenly"),
        ("Recruiting", {"recruiting": "pilot"}, "open", "“recruiting” is “live”"),
        ("Exclusion rules", {"exclusion": ()}, "open", "none is declared"),
        (
            "Orders of the conditions",
            {"order": {"kind": "fixed", "rows": (("varil", "arroch", "crmiar"),)}},
            "open",
            "follow one another more often",
        ),
        ("Orders of the conditions", {"conditions": ("varil",)}, "open", "only one condition"),
        ("Texts", {"title": "Study XXX"}, "problem", "“XXX”"),
    ],
)
def test_a_point_of_the_study_turns_by_its_own_cause(
    study: Study, title: str, changes: dict[str, Any], state: str, told: str
) -> None:
    """And, but for what hangs on the same cause, no other one turns."""
    found = points(launched(study, **changes))
    assert (found[title].state, told in found[title].detail) == (state, True)
    turned = {name for name, point in found.items() if point.state == "problem"}
    assert turned <= {title}


@pytest.mark.parametrize(
    ("title", "change", "state", "told"),
    [
        ("Rehearsal", {"tried": 0}, "problem", "try it with pilots or bots"),
        ("Real time", {"time_scale": 4.0}, "problem", "4 times as fast"),
        ("Encrypted connection", {"is_https": False}, "problem", "plain http"),
        ("Policy of the adaptive display", {"policy_origin": None}, "done", "no condition"),
        ("Policy of the adaptive display", {"policy_origin": "initial"}, "open", "nothing was"),
        ("Policy of the adaptive display", {"policy_origin": "simulated"}, "problem", "simulated"),
    ],
)
def test_a_point_of_the_surroundings_turns_by_its_own_cause(
    study: Study, title: str, change: dict[str, Any], state: str, told: str
) -> None:
    ready, now = points(launched(study)), points(launched(study), replace(READY, **change))
    assert (now[title].state, told in now[title].detail) == (state, True)
    assert {name for name in now if now[name] != ready[name]} == {title}


def test_pilots_may_meet_a_simulated_policy(study: Study) -> None:
    around = replace(READY, policy_origin="simulated")
    found = points(launched(study, recruiting="pilot"), around)
    assert found["Policy of the adaptive display"].state == "open"


def test_a_shared_code_is_a_problem(study: Study) -> None:
    """A panel could not tell the two outcomes apart."""
    code = study.endings["completed"].code
    shared = study.endings["withdrawn"].model_copy(update={"code": code})
    twin = study.model_copy(update={"endings": {**study.endings, "withdrawn": shared}})
    assert points(twin)["Completion codes"].state == "problem"


@pytest.mark.parametrize(
    ("mark", "is_found"), [("TODO", True), ("AXXXB", False), ("MyTODOs", False)]
)
def test_placeholders_are_whole_words(study: Study, mark: str, is_found: bool) -> None:
    """At the start of a line too; letters inside a word are none, as a drawn code may hold any."""
    texts = study.texts.model_dump() | {"contact": f"us\n{mark} or them"}
    found = points(launched(study, texts=texts))["Texts"]
    assert (found.state == "problem") == is_found


def test_consent_that_asks_for_nothing_is_a_problem(study: Study) -> None:
    """No valid study file can hold this; the checklist does not rely on that."""
    none = study.consent.model_copy(update={"items": ()})
    one = study.consent.model_copy(update={"items": study.consent.items[:1]})
    assert points(study.model_copy(update={"consent": none}))["Consent"].state == "problem"
    told = points(study.model_copy(update={"consent": one}))["Consent"]
    assert (told.state, told.detail) == ("done", "1 statement must be agreed to")
