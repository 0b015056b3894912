"""Guards pages that ask: every kind of item is shown, validated on the server, and comes back."""

from __future__ import annotations

import html
import re
import sqlite3
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page

from server.settings import Settings
from study.config import Study
from tests.server.pages.looking import problems_of

OWN: dict[str, Any] = {
    "name": "own",
    "title": "And *the* rest",
    "introduction": "Think **well**.",
    "items": [
        {"kind": "slider", "name": "trust", "label": "Trust?", "low": "none", "high": "full"},
        {"kind": "number", "name": "seen", "label": "Seen?", "lowest": 0, "highest": 12},
        {"kind": "choice", "name": "hand", "label": "Hand?", "options": ["Left", "Right"]},
        {"kind": "text", "name": "why", "label": "Why?", "required": True, "longest": 50},
        {"kind": "rating", "name": "mood", "label": "Mood?", "low": "bad", "high": "good"},
    ],
}
TLX = ("mental", "physical", "temporal", "performance", "effort", "frustration")
RIGHT = dict.fromkeys(TLX, "45") | {
    "trust": "70", "seen": "3", "hand": "left", "why": "=1+1", "mood": "7",
}  # fmt: skip


@pytest.fixture
def study(study: Study) -> Study:
    """A study that asks everything there is, after each trial and once at the end."""
    return study.revised(
        conditions=("none",),
        questionnaire=[
            {"use": "nasa-tlx", "random_order": True},
            OWN,
            {"use": "sus", "place": "end"},
        ],
    )


def test_a_page_with_two_instruments_shows_every_kind_of_item(walker: Any) -> None:
    walker.walk_to("questionnaire-1")
    page = walker.page().text
    assert len(re.findall(r'type="radio" name="mental"', page)) == 21
    assert '<h2 id="part-2">And *the* rest</h2>' in page
    assert "<strong>well</strong>" in page
    assert 'name="trust"' in page
    for name in RIGHT:
        assert f'id="{name}"' in page
    assert "style=" not in page, "the content policy forbids styles in tags"


def test_a_random_order_is_stored_as_it_was_shown(
    join: Callable[[], Any], settings: Settings
) -> None:
    """Each of five people; that all five draw the published order has a chance below 1 in 10^14."""
    shown: list[list[str]] = []
    for _ in range(5):
        walker = join()
        walker.walk_to("questionnaire-1")
        page = walker.page().text
        items = [*TLX, *(item["name"] for item in OWN["items"])]
        shown.append(sorted(items, key=lambda name: page.index(f'id="{name}"')))
        walker.send("questionnaire-1", RIGHT)
    with sqlite3.connect(settings.var_dir / "varil.sqlite3") as database:
        rows = database.execute(
            "SELECT item, item_order FROM responses WHERE step = 'questionnaire-1' "
            "ORDER BY participant_id, item_order"
        ).fetchall()
    stored = [[item for item, _ in rows[k : k + 11]] for k in range(0, len(rows), 11)]
    assert [order for _, order in rows] == [*range(1, 12)] * 5
    assert stored == shown
    assert any(tuple(order[:6]) != TLX for order in shown)
    assert all(order[6:] == items[6:] for order in shown), "only the instrument that asks for it"


def test_answers_of_every_kind_are_taken_and_the_end_asks_its_own(walker: Any) -> None:
    walker.walk_to("questionnaire-1")
    assert walker.send("questionnaire-1", RIGHT).status_code == 303
    assert walker.step() == "final"
    assert walker.send("questionnaire-1", RIGHT).status_code == 303, "the same again is welcome"
    assert "About the system as a whole" in walker.page().text
    sus = {f"sus_{k}": "3" for k in range(1, 11)}
    assert walker.send("final", sus).status_code == 303
    assert walker.step() == "comments"


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("mental", "42", "Please choose one of the points."),
        ("mental", "", "Please choose one of the points."),
        ("trust", "", "Please move the slider, or enter a number from 0 to 100."),
        ("trust", "101", "Please move the slider"),
        ("seen", "13", "Please enter a whole number from 0 to 12."),
        ("hand", "both", "Please choose one of the answers."),
        ("why", "  ", "Please write something here."),
        ("why", "x" * 60_000, "Please shorten this to 50 characters; it has 60000 now."),
        ("mood", "8", "Please choose one of the points."),
    ],
)
def test_what_does_not_fit_comes_back_with_its_sentence(
    walker: Any, name: str, value: str, sentence: str
) -> None:
    walker.walk_to("questionnaire-1")
    answer = walker.send("questionnaire-1", RIGHT | {name: value})
    assert answer.status_code == 422
    page = html.unescape(answer.text)
    assert sentence in page
    assert page.count('class="problem"') == 1
    assert f'id="{name}-problem"' in page
    assert 'value="45" checked' in page
    assert walker.step() == "questionnaire-1"


@pytest.mark.browser
def test_questions_can_be_answered_by_mouse_and_by_keyboard(
    chromium_page: Page, walker: Any
) -> None:
    """A slider has no answer until it is moved; a ruler of 21 points is a group of radios."""
    walker.walk_to("questionnaire-1")
    page = chromium_page
    page.goto(f"http://testserver{walker.address}")
    assert problems_of(page) == []
    slider = page.get_by_role("slider")
    assert slider.get_attribute("aria-valuetext") == "nothing chosen yet"
    assert page.input_value("#trust") == ""
    slider.focus()
    page.keyboard.press("ArrowRight")
    assert page.input_value("#trust") == "51"
    assert slider.get_attribute("aria-valuetext") is None
    page.fill("#trust", "70")
    assert slider.input_value() == "70"
    page.fill("#trust", "")
    assert slider.get_attribute("aria-valuetext") == "nothing chosen yet"
    slider.click()
    assert page.input_value("#trust") == "50"
    page.focus("#mental")
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    assert page.locator("input[name=mental]:checked").get_attribute("value") == "15"
    page.get_by_role("group", name="Effort").get_by_role("radio", name="100 Very high").check()
    page.click("button[type=submit]")
    page.wait_for_selector("#summary:focus")
    assert problems_of(page) == []
    assert page.locator("input[name=effort]:checked").get_attribute("value") == "100"
    assert page.get_by_role("slider").input_value() == "50"


def test_a_text_of_100_kb_is_refused_and_stores_nothing(walker: Any) -> None:
    walker.walk_to("questionnaire-1")
    assert walker.send("questionnaire-1", RIGHT | {"why": "x" * 100_000}).status_code == 413
    assert walker.step() == "questionnaire-1"


def test_the_schema_of_study_files_is_served(client: Any) -> None:
    answer = client.get("/study.schema.json")
    assert answer.headers["content-type"] == "application/schema+json"
    assert answer.json()["properties"]["conditions"]["maxItems"] == 5
