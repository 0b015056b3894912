"""Every error of the experiment, as one tree.

::

    StudyError                  something the caller can mend; carries data, derives its sentence
    ├── InvalidValue            a value at the door is not allowed
    │   ├── LayoutError         a hall cannot be built as asked
    │   ├── PolicyError         a policy file is not usable
    │   ├── StudyFileError      a study file has mistakes; carries all of them
    │   ├── AnswerError         answers of a form are missing or off the scale
    │   └── JournalError        stored inputs do not reproduce the recorded trial
    ├── NotFound                no such study, token, trial or step
    │   ├── UnknownStudy
    │   ├── UnknownToken
    │   ├── UnknownRun
    │   └── UnknownCondition
    └── WrongMoment             right request, wrong time
        ├── WrongStep           a form or socket for another step than the current one
        └── NotAllowedLive      a rehearsal aid asked for by a live participant

An error's sentence says what happened, where, and what to do next.
This module imports nothing of ours.
"""

from __future__ import annotations

from typing import Any


class StudyError(Exception):
    """Root of the tree: `what` happened, `where`, and what to do `next_step`."""

    def __init__(self, what: str, *, where: str = "", next_step: str = "") -> None:
        self.what = what
        self.where = where
        self.next_step = next_step
        super().__init__(self.sentence)

    @property
    def sentence(self) -> str:
        """One readable sentence made from the error's data."""
        place = f"{self.where}: " if self.where else ""
        advice = f" {self.next_step}" if self.next_step else ""
        return f"{place}{self.what}.{advice}"


class InvalidValue(StudyError):
    """A value at the door is not allowed."""


class LayoutError(InvalidValue):
    """A hall cannot be built from the given parameters."""


class PolicyError(InvalidValue):
    """A policy file is incomplete, damaged or made for something else."""


class StudyFileError(InvalidValue):
    """A study file was refused; `problems` are all that was found (place, value, message)."""

    def __init__(self, problems: list[Any], where: str = "") -> None:
        self.problems = problems
        count = "one mistake" if len(problems) == 1 else f"{len(problems)} mistakes"
        super().__init__(
            f"the study file has {count}",
            where=where,
            next_step="`varil validate` lists them with their places.",
        )


class JournalError(InvalidValue):
    """Stored inputs do not reproduce the recorded trial."""


class AnswerError(InvalidValue):
    """Answers of a form were refused; `problems` maps each field to its sentence."""

    def __init__(self, problems: dict[str, str]) -> None:
        self.problems = problems
        fields = ", ".join(sorted(problems))
        super().__init__(
            f"{len(problems)} answer(s) need attention ({fields})",
            next_step="The sentence beside each field says what is allowed there.",
        )


class NotFound(StudyError):
    """Something named by the caller does not exist."""


class UnknownStudy(NotFound):
    """No study has this id."""

    def __init__(self, study_id: str) -> None:
        self.study_id = study_id
        super().__init__(
            f"there is no study “{study_id[:40]}” here",
            next_step="Check the link you were sent, or ask the researcher for a new one.",
        )


class UnknownToken(NotFound):
    """No participant has this token; the token itself is never repeated."""

    def __init__(self) -> None:
        super().__init__(
            "this personal link is not known here",
            next_step="Check that the whole link was copied, or join again from the first link.",
        )


class UnknownRun(NotFound):
    """No learning run has this id."""

    def __init__(self, run_id: str) -> None:
        self.run_id = run_id
        super().__init__(
            f"there is no learning run “{run_id[:40]}” here",
            next_step="Open the list of learning runs and choose one of them.",
        )


class UnknownCondition(NotFound):
    """No condition has this name."""

    def __init__(self, name: str, known: tuple[str, ...]) -> None:
        self.name = name
        self.known = known
        super().__init__(
            f"there is no condition “{name[:40]}”", next_step=f"Use one of: {', '.join(known)}."
        )


class WrongMoment(StudyError):
    """The request is sound but does not fit what is going on."""


class WrongStep(WrongMoment):
    """A form or socket belongs to another step than the participant's current one."""

    def __init__(self, asked: str, current: str) -> None:
        self.asked = asked
        self.current = current
        super().__init__(
            f"the step “{asked[:40]}” is not the current one",
            next_step="Nothing was changed; your personal link always opens the current step.",
        )


class NotAllowedLive(WrongMoment):
    """A rehearsal aid was asked for while people take part for real."""

    def __init__(self, aid: str) -> None:
        self.aid = aid
        super().__init__(
            f"{aid} is refused for live participants",
            next_step="Use a study that recruits pilots, or leave the setting at its default.",
        )
