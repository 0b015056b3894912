"""Administrators' page of one participant: the whole story, excluding, reinstating, notes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Any

from fastapi import APIRouter, Depends
from starlette.responses import RedirectResponse, Response

from server.deps import AdminDep, AdminDeskDep, FormDep, ServicesDep
from server.desks.stories import Story
from server.pages.admin_frame import Frame
from server.pages.admin_people import describe_person
from study.config import Study
from study.errors import InvalidValue
from study.protocol.exclusions import flag_participant, flag_trial

router = APIRouter(prefix="/admin/participants/{code}", include_in_schema=False)


@dataclass(frozen=True)
class StoryPage:
    """The page of the participant with this code."""

    code: str
    services: ServicesDep
    user: AdminDep
    desk: AdminDeskDep

    async def answer(self, problems: Mapping[str, str]) -> Response:
        """The story, with what was wrong with a form that was sent."""
        story = await self.services.stories.tell(self.code)
        study, person = story.study, story.person
        played = _flag_trials(story)
        values = vars(story) | {
            "person": describe_person(person, study),
            "version": study.config_hash,
            "flags": flag_participant(study.exclusion, played),
            "labels": _labels(study),
            "steps": _steps(story),
            "preview": await self.desk.preview(study, self.code),
            "problems": problems,
        }
        shown = self.services.participants.studies.get(person.study_id, study)
        frame = Frame(self.services, self.user, shown, "")
        values["study"] = shown
        return frame.page("admin-participant.html", values, 422 if problems else 200)

    def again(self, anchor: str = "") -> Response:
        """Back to the story after something was done."""
        return RedirectResponse(f"/admin/participants/{self.code.upper()}{anchor}", 303)


StoryPageDep = Annotated[StoryPage, Depends()]


@router.get("")
async def show_participant(page: StoryPageDep) -> Response:
    """Everything that is known of one participant."""
    return await page.answer({})


@router.post("/exclude")
async def exclude(page: StoryPageDep, form: FormDep) -> Response:
    """Take a participant out of the analysis, with a reason."""
    try:
        await page.services.lives.exclude(page.code, form.get("reason", ""), page.user.name)
    except InvalidValue as error:
        return await page.answer({"reason": error.sentence})
    return page.again()


@router.post("/reinstate")
async def reinstate(page: StoryPageDep, form: FormDep) -> Response:
    """Take an exclusion back, with a reason."""
    try:
        await page.services.lives.reinstate(page.code, form.get("reason", ""), page.user.name)
    except InvalidValue as error:
        return await page.answer({"reason": error.sentence})
    return page.again()


@router.post("/note")
async def write_note(page: StoryPageDep, form: FormDep) -> Response:
    """Keep a note about a participant."""
    try:
        await page.desk.note(page.code, form.get("note", ""), page.user.name)
    except InvalidValue as error:
        return await page.answer({"note": error.sentence})
    return page.again("#notes")


def _flag_trials(story: Story) -> list[dict[str, Any]]:
    """Write into each trial which exclusion rules it breaks; returns the trials that ended."""
    played = [t for t in story.trials if t["kind"] == "trial" and t["status"] != "open"]
    for trial in story.trials:
        flags = flag_trial(story.study.exclusion, trial) if trial in played else []
        trial["flags"] = flags
    return played


def _steps(story: Story) -> list[dict[str, Any]]:
    """Each step with when it was shown and when it was left, as far as is known."""
    person = story.person
    sent: dict[str, tuple[datetime | None, datetime]] = {
        a["step"]: (a["shown_at"], a["answered_at"]) for a in story.answers
    }
    for trial in story.trials:
        sent[trial["step"]] = (trial["opened_at"], trial["ended_at"])
    steps = story.study.plan.steps
    at = steps.index(person.progress.step) if person.progress.step in steps else -1
    return [
        {
            "name": step,
            "shown": sent.get(step, (None, None))[0] or (person.step_shown_at if k == at else None),
            "left": sent.get(step, (None, None))[1],
            "state": "done" if k < at or step == "debrief" == person.progress.step else "now",
        }
        for k, step in enumerate(steps)
        if k <= at
    ]


def _labels(study: Study) -> dict[str, str]:
    return {item.name: item.label for one in study.all_instruments for item in one.items}
