"""Guards forms that come back: errors beside the field and above it, and nothing typed is lost."""

from __future__ import annotations

import html
from typing import Any

import pytest

CASES = [
    ("consent", {"adult": "yes", "informed": "yes"}, ["agreed"], ['name="adult"']),
    (
        "demographics",
        {"age": "17", "gender": "man", "games_3d": "sometimes"},
        ["age", "games_3d", "colour_vision"],
        ['value="17"', 'value="man" checked'],
    ),
    (
        "questionnaire-1",
        {"Q1": "4", "Q2": "6", "Q3": "0", "Q4": "", "Q5": "5 "},
        ["Q2", "Q3", "Q4", "Q5", "Q6"],
        ['name="Q1" value="4" checked'],
    ),
    (
        "comments",
        {"remarks": "<b>hello</b> & “you”", "problems": "x" * 2001},
        ["problems"],
        ["&lt;b&gt;hello&lt;/b&gt; &amp; “you”", "x" * 2001],
    ),
]


@pytest.mark.parametrize(("step", "form", "wrong", "kept"), CASES, ids=[c[0] for c in CASES])
def test_a_refused_form_comes_back_as_it_was_typed(
    walker: Any, step: str, form: dict[str, str], wrong: list[str], kept: list[str]
) -> None:
    walker.walk_to(step)
    answer = walker.send(step, form)
    page = answer.text
    assert answer.status_code == 422
    for name in wrong:
        assert f'href="#{name}"' in page
        assert f'id="{name}-problem"' in page
        assert f'id="{name}"' in page
    assert page.count('class="problem"') == len(wrong)
    for typed in kept:
        assert typed in page
    assert walker.step() == step


def test_ticked_boxes_stay_ticked(walker: Any) -> None:
    page = walker.send("consent", {"adult": "yes"}).text
    adult = page[page.index('id="adult"') :].split(">")[0]
    agreed = page[page.index('id="agreed"') :].split(">")[0]
    assert "checked" in adult
    assert "checked" not in agreed


@pytest.mark.parametrize(
    ("change", "advice"),
    [
        ({"webgl": "no"}, "WebGL 2 is missing"),
        ({"touch_only": "yes"}, "only a touch screen"),
        ({"webgl": ""}, "allow JavaScript"),
    ],
)
def test_a_device_that_will_not_do_is_told_and_another_may_go_on(
    walker: Any, change: dict[str, str], advice: str
) -> None:
    device = {"keyboard": "yes", "mouse": "yes", "webgl": "yes", "touch_only": "no"}
    walker.walk_to("browser-check")
    answer = walker.send("browser-check", device | change)
    assert answer.status_code == 422
    assert advice in html.unescape(answer.text)
    assert walker.send("browser-check", device).status_code == 303
    assert walker.step() == "demographics"


def test_a_form_with_files_or_too_many_fields_is_refused_without_harm(walker: Any) -> None:
    many = {f"f{k}": "1" for k in range(300)}
    assert walker.send("consent", many).status_code == 400
    files = {"adult": ("a.txt", b"yes")}
    answer = walker.client.post(f"{walker.address}/consent", files=files)
    assert answer.status_code == 400
    assert walker.step() == "consent"


def test_bytes_that_are_no_text_do_no_harm(walker: Any) -> None:
    walker.walk_to("comments")
    answer = walker.client.post(
        f"{walker.address}/comments",
        content=b"remarks=%FF%FE%00%ED%A0%80&problems=",
        headers={"content-type": "application/x-www-form-urlencoded"},
    )
    assert answer.status_code == 303
    assert walker.step() == "debrief"
