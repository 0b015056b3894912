"""Records for the texts of a study: plain paragraphs and points, no markup."""

from __future__ import annotations

from study.protocol.questionnaires import Record


class Section(Record):
    """A heading with paragraphs and, below them, points."""

    heading: str = ""
    paragraphs: tuple[str, ...] = ()
    points: tuple[str, ...] = ()


class PageText(Record):
    """What one page says: its title, a lead sentence and sections."""

    title: str
    lead: str = ""
    sections: tuple[Section, ...] = ()


class ElementText(Record):
    """What an element of the display looks like and what it tells."""

    name: str
    title: str
    text: str
    picture_alt: str


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
    practice_failed: str
    elements: tuple[ElementText, ...]
    adaptive_display: str
    steady_display: str
    plain_display: str
    debrief: PageText
    screened_out: PageText
    withdrawn: PageText
    timed_out: PageText
    excluded: PageText = EXCLUDED
    contact: str
