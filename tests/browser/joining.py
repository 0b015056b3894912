"""Brings a participant to a step by posting the forms, as their browser would."""

from __future__ import annotations

import httpx2
from playwright.sync_api import Page

FORMS: dict[str, dict[str, str]] = {
    "consent": {"adult": "yes", "informed": "yes", "agreed": "yes"},
    "browser-check": {
        "keyboard": "yes",
        "mouse": "yes",
        "webgl": "yes",
        "touch_only": "no",
        "frame_rate_hz": "60.0",
        "latency_ms": "3.0",
    },
    "demographics": {"age": "31", "gender": "woman", "games_3d": "never", "colour_vision": "no"},
    "instructions": {},
}


def join_and_go_to(url: str, study: str, step: str) -> str:
    """Join and send every form before `step`; returns the personal address.

    Raises:
        AssertionError: a form was refused, or an answer wanted to store a cookie.
    """
    with httpx2.Client(base_url=url) as client:
        answers = [client.post(f"/s/{study}", data={})]
        place = answers[0].headers["location"]
        for name, form in FORMS.items():
            if name == step:
                break
            answers.append(client.post(f"{place}/{name}", data=form))
    for answer in answers:
        assert answer.status_code == 303, answer.text
        assert "set-cookie" not in answer.headers
    return f"{url}{place}"


def wait_for_running(page: Page) -> None:
    """Wait until the world runs on a trial page."""
    page.wait_for_function("() => document.querySelector('#stage').dataset.phase === 'running'")
