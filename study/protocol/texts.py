"""Records for the texts of a study. Bodies, leads and introductions are Markdown without HTML."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from study.protocol.records import Record

Line = Annotated[str, Field(min_length=1, max_length=200)]
Lead = Annotated[str, Field(max_length=2000)]
Body = Annotated[str, Field(max_length=30_000)]


class PageText(Record):
    """What one page says: its title, a lead sentence, and a body with headings and lists."""

    title: Line
    lead: Lead = ""
    body: Body = ""


class ElementText(Record):
    """What an element of the display looks like and what it tells."""

    name: str
    title: Line
    text: Annotated[str, Field(min_length=1, max_length=2000)]
    picture_alt: Annotated[str, Field(min_length=1, max_length=500)]


EXCLUDED = PageText(
    title="Your participation was ended",
    lead="The researchers ended your participation. Nothing more is recorded.",
)


class StudyTexts(Record):
    """Every text of a study that is not a questionnaire."""

    welcome: PageText
    consent: PageText
    browser_check: PageText
    instructions: PageText
    practice_failed: Annotated[str, Field(min_length=1, max_length=2000)]
    elements: tuple[ElementText, ...]
    adaptive_display: Annotated[str, Field(min_length=1, max_length=2000)]
    steady_display: Annotated[str, Field(min_length=1, max_length=2000)]
    plain_display: Annotated[str, Field(min_length=1, max_length=2000)]
    debrief: PageText
    screened_out: PageText
    withdrawn: PageText
    timed_out: PageText
    excluded: PageText = EXCLUDED
    contact: Line
