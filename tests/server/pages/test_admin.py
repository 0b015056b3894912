"""Guards the administrators' pages: with nobody, with one participant, and what staff do there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from starlette.testclient import TestClient

PAGES = (
    "/admin", "/admin/live", "/admin/participants", "/admin/conditions", "/admin/data",
    "/admin/data/codebook", "/admin/study", "/admin/policies", "/admin/audit",
)  # fmt: skip


def code_of(walker: Any) -> str:
    desk = walker.app.state.services.participants
    return str(walker.client.portal.call(desk.look_up, walker.token).participant.code)


@pytest.mark.parametrize("path", PAGES)
def test_each_page_answers_without_anybody_and_marks_itself(
    sign_in_as: Callable[[str], TestClient], path: str
) -> None:
    """An empty study has designed pages too, and the navigation says which one is open."""
    page = sign_in_as("admin").get(path)
    assert page.status_code == 200
    assert page.text.count('aria-current="page"') >= 1
    assert "style=" not in page.text


def test_each_page_answers_with_a_participant(
    sign_in_as: Callable[[str], TestClient], walker: Any
) -> None:
    """What participants leave is listed on every page that speaks of it."""
    walker.walk_to("debrief")
    code = code_of(walker)
    admin = sign_in_as("admin")
    for path in PAGES:
        assert admin.get(path).status_code == 200, path
    assert code in admin.get("/admin/participants").text
    assert code in admin.get("/admin/conditions").text
    story = admin.get(f"/admin/participants/{code}").text
    assert "replay trial-3" in story
    assert "Q6" in story
    assert 'data-state="problem"' not in admin.get("/admin/data").text


def test_exclude_and_reinstate_with_a_preview(
    sign_in_as: Callable[[str], TestClient], walker: Any, audit: Callable[[], Any]
) -> None:
    """Both need a reason, say before what becomes of the cell, and are audited."""
    walker.walk_to("debrief")
    address = f"/admin/participants/{code_of(walker)}"
    admin = sign_in_as("admin")
    assert "completed 1 → <strong>0</strong>" in admin.get(address).text
    refused = admin.post(f"{address}/exclude", data={"reason": " "})
    assert refused.status_code == 422
    assert "a reason of 1 to" in refused.text
    assert admin.post(f"{address}/exclude", data={"reason": "slept"}).status_code == 303
    page = admin.get(address).text
    assert "slept" in page
    assert "completed 0 → <strong>1</strong>" in page
    assert admin.post(f"{address}/reinstate", data={"reason": "was awake"}).status_code == 303
    assert [what for _, what, _ in audit()] == ["participant excluded", "participant reinstated"]


def test_notes_are_kept_with_their_moment(
    sign_in_as: Callable[[str], TestClient], walker: Any, audit: Callable[[], Any]
) -> None:
    """A note about a participant and one about a tick of a trial stand in the story, escaped."""
    walker.walk_to("trial-1")
    trial = walker.end_trial()
    code, admin = code_of(walker), sign_in_as("admin")
    admin.post(f"/admin/participants/{code}/note", data={"note": "called <us>"})
    admin.post(f"/admin/live/{trial}/note", data={"note": "stuck here", "tick": "300"})
    story = admin.get(f"/admin/participants/{code}").text
    assert "called &lt;us&gt;" in story
    assert "trial-1 at 10.0 s" in story
    assert admin.post(f"/admin/live/{trial}/note", data={"note": "x", "tick": "-1"}).is_error
    assert len(audit()) == 2


@pytest.mark.parametrize(
    ("query", "found"),
    [("mode=bot", False), ("status=completed", False), ("text=consent", True), ("sort=x", True)],
)
def test_participants_can_be_filtered(
    sign_in_as: Callable[[str], TestClient], walker: Any, query: str, found: bool
) -> None:
    """Filters take effect, and what makes no sense stands for everything."""
    code = code_of(walker)
    assert (code in sign_in_as("admin").get(f"/admin/participants?{query}").text) is found


def test_every_page_of_the_study_can_be_previewed(
    sign_in_as: Callable[[str], TestClient], walker: Any
) -> None:
    """The texts are seen as participants see them."""
    admin = sign_in_as("admin")
    study = walker.app.state.services.participants.studies["demo"]
    for step in (*study.plan.steps, "screened-out", "withdrawn", "timed-out", "excluded"):
        if step != "practice" and not step.startswith("trial-"):
            assert admin.get(f"/admin/study/preview/{step}").status_code == 200, step
    assert admin.get("/admin/study/preview/trial-1").status_code == 404
