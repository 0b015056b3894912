"""The steps of a participation as a pure state machine.

::

    consent -> browser-check -> demographics -> instructions -> practice
        -> 3 x (explanation-k -> trial-k -> questionnaire-k) -> final -> comments -> debrief

    a step on which the study asks nothing is left out (demographics, questionnaire-k, final,
    comments)

    practice, not passed -> instructions again, or `screened-out` after the last try
    any step             -> `withdrawn` | `timed-out`

`advance(plan, progress, submission)` is the only way to move; it raises `WrongStep` for a
submission that belongs elsewhere and changes nothing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Literal

from study.errors import NotFound, WrongStep

Outcome = Literal["completed", "screened-out", "withdrawn", "timed-out"]
OUTCOMES: tuple[Outcome, ...] = ("completed", "screened-out", "withdrawn", "timed-out")
TrialEnd = Literal["completed", "timed_out"]

_FIRST = ("consent", "browser-check", "demographics", "instructions", "practice")
_REPEATED = ("explanation", "trial", "questionnaire")
_LAST = ("final", "comments", "debrief")
OPTIONAL = frozenset({"demographics", "questionnaire", "final", "comments"})
_STEP_PATTERN = re.compile(r"(?P<kind>[a-z-]+?)(?:-(?P<position>[1-9][0-9]?))?")


class UnknownStep(NotFound):
    """No study has a step of this name."""

    def __init__(self, step: str) -> None:
        self.step = step
        super().__init__(
            f"there is no step “{step[:40]}”",
            next_step="Your personal link always opens the current step.",
        )


@dataclass(frozen=True)
class Plan:
    """What the machine must know of a study.

    `left_out`: kinds of steps (of `OPTIONAL`) on which the study asks nothing.
    """

    trials: int
    practice_tries: int
    left_out: frozenset[str] = frozenset({"final"})

    @property
    def steps(self) -> tuple[str, ...]:
        """Every step id in order."""
        repeated = [kind for kind in _REPEATED if kind not in self.left_out]
        return (
            *(kind for kind in _FIRST if kind not in self.left_out),
            *(f"{kind}-{k}" for k in range(1, self.trials + 1) for kind in repeated),
            *(kind for kind in _LAST if kind not in self.left_out),
        )


@dataclass(frozen=True)
class Progress:
    """Where a participant is; `outcome` is set once and for all when the participation ends."""

    step: str
    practice_tries: int = 0
    outcome: Outcome | None = None

    @property
    def page(self) -> str:
        """The page to show: the step, or the outcome's page if it ended early."""
        return self.step if self.outcome in (None, "completed") else self.outcome


@dataclass(frozen=True)
class FormSent:
    """A form of this step was filled in validly."""

    step: str


@dataclass(frozen=True)
class TrialEnded:
    """The world of a trial or practice step came to its end."""

    step: str
    status: TrialEnd


@dataclass(frozen=True)
class Withdrawal:
    """The participant wants to stop and have the data left out."""


@dataclass(frozen=True)
class IdleTooLong:
    """Nothing was heard of the participant for the study's limit."""


Submission = FormSent | TrialEnded | Withdrawal | IdleTooLong


def start(plan: Plan) -> Progress:
    """The progress of somebody who has just joined."""
    return Progress(plan.steps[0])


def step_kind(step: str) -> tuple[str, int | None]:
    """Kind and position of a step id: `trial-2` -> ("trial", 2), `consent` -> ("consent", None)."""
    match = _STEP_PATTERN.fullmatch(step)
    if match is None:
        raise UnknownStep(step)
    position = match["position"]
    kind = match["kind"]
    if (position is None) == (kind in _REPEATED) or kind not in (*_FIRST, *_REPEATED, *_LAST):
        raise UnknownStep(step)
    return kind, int(position) if position else None


def is_trial(step: str) -> bool:
    """Whether this step is played in the world rather than filled in."""
    return step_kind(step)[0] in ("practice", "trial")


def comes_before(plan: Plan, step: str, progress: Progress) -> bool:
    """Whether `step` is behind the participant already."""
    steps = plan.steps
    if step not in steps:
        raise UnknownStep(step)
    return steps.index(step) < steps.index(progress.step)


def advance(plan: Plan, progress: Progress, submission: Submission) -> Progress:
    """The progress after a submission; raises `WrongStep` if it does not belong here."""
    if isinstance(submission, Withdrawal):
        return _withdraw(progress)
    if isinstance(submission, IdleTooLong):
        return progress if progress.outcome else replace(progress, outcome="timed-out")
    if progress.outcome is not None or submission.step != progress.step:
        raise WrongStep(submission.step, progress.page)
    if isinstance(submission, TrialEnded) != is_trial(progress.step):
        raise WrongStep(submission.step, progress.page)
    if isinstance(submission, TrialEnded) and progress.step == "practice":
        return _after_practice(plan, progress, passed=submission.status == "completed")
    return _next_step(plan, progress)


def _withdraw(progress: Progress) -> Progress:
    """Withdrawing works at any point, also after completion; nobody is screened out twice."""
    if progress.outcome in (None, "completed"):
        return replace(progress, outcome="withdrawn")
    return progress


def _after_practice(plan: Plan, progress: Progress, *, passed: bool) -> Progress:
    tried = replace(progress, practice_tries=progress.practice_tries + 1)
    if passed:
        return _next_step(plan, tried)
    if tried.practice_tries >= plan.practice_tries:
        return replace(tried, outcome="screened-out")
    return replace(tried, step="instructions")


def _next_step(plan: Plan, progress: Progress) -> Progress:
    steps = plan.steps
    position = steps.index(progress.step) + 1
    if position >= len(steps):
        raise WrongStep(progress.step, progress.page)
    step = steps[position]
    done: Outcome | None = "completed" if position == len(steps) - 1 else None
    return replace(progress, step=step, outcome=done)
