"""Guards that participants never meet the names of the conditions, and read no half-made text."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from server.locations import web_root
from study.protocol.flow import Plan

SECRET = re.compile(r"varil|arroch|crmiar", re.IGNORECASE)
BUNDLES = ("play.js", "check.js", "form.js", "page.css", "play.css")


def test_no_step_names_a_condition(walker: Any) -> None:
    for step in Plan(3, 3).steps:
        walker.walk_to(step)
        page = walker.page().text
        assert SECRET.search(page) is None, f"{step}: {SECRET.search(page)}"
        assert "{{" not in page
    walker.send("withdraw")
    assert SECRET.search(walker.page().text) is None


@pytest.mark.parametrize(
    "address", ["/", "/s/demo", "/s/nope", "/p/unknown", "/nothing", "/p/x/withdraw"]
)
def test_no_page_a_participant_may_meet_names_a_condition(client: TestClient, address: str) -> None:
    answer = client.get(address)
    assert SECRET.search(answer.text) is None
    assert SECRET.search(str(answer.headers)) is None


@pytest.mark.parametrize("name", BUNDLES)
def test_no_bundle_names_a_condition(name: str) -> None:
    bundle: Path = web_root() / "static/dist" / name
    if not bundle.is_file():
        pytest.fail(f"{name} is not built; run `make install`")
    chunks = [bundle, *bundle.parent.glob("chunk-*.js")]
    assert [file.name for file in chunks if SECRET.search(file.read_text())] == []
