"""The steps of a participation as a pure state machine.

::

    consent -> browser-check -> demographics -> instructions -> practice
        -> 3 x (explanation-k -> trial-k -> questionnaire-k) -> final -> comments -> debrief

    a step on which the study asks nothing is left out (demographics, questionnaire-k, final,
    comments)

    practice, not passed -> instructions again, or `screened-out` after the last try
    any step             -> `withdrawn` | `timed-out` | `excluded`

`advance(plan, progress, submission)` is the only way to move; it raises `WrongStep` for a
submission that belongs elsewhere and changes nothing. What becomes of the participation as a
whole is decided by `study.protocol.lifecycle`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Literal

from study.errors import NotFound, WrongStep
from study.protocol.lifecycle import OUTCOMES, Life, Outcome, change

__all__ = ["OUTCOMES", "Outcome"]

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
    """Where a participant is, and how the participation as a whole stands."""

    step: str
    practice_tries: int = 0
    life: Life = field(default_factory=Life)

    @property
    def outcome(self) -> Outcome | None:
        """How the participation ended, or None while it is under way."""
        return self.life.outcome

    @property
    def page(self) -> str:
        """The page to show: the step, or the outcome's page if it ended early."""
        told = self.life.told
        return told if told in OUTCOMES and told != "completed" else self.step


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
        return replace(progress, life=change(progress.life, "withdraw"))
    if isinstance(submission, IdleTooLong):
        return replace(progress, life=change(progress.life, "time-out"))
    if progress.outcome is not None or submission.step != progress.step:
        raise WrongStep(submission.step, progress.page)
    if isinstance(submission, TrialEnded) != is_trial(progress.step):
        raise WrongStep(submission.step, progress.page)
    begun = replace(progress, life=change(progress.life, "begin"))
    if isinstance(submission, TrialEnded) and progress.step == "practice":
        return _after_practice(plan, begun, passed=submission.status == "completed")
    return _next_step(plan, begun)


def _after_practice(plan: Plan, progress: Progress, *, passed: bool) -> Progress:
    tried = replace(progress, practice_tries=progress.practice_tries + 1)
    if passed:
        return _next_step(plan, tried)
    if tried.practice_tries >= plan.practice_tries:
        return replace(tried, life=change(tried.life, "screen-out"))
    return replace(tried, step="instructions")


def _next_step(plan: Plan, progress: Progress) -> Progress:
    steps = plan.steps
    position = steps.index(progress.step) + 1
    if position >= len(steps):
        raise WrongStep(progress.step, progress.page)
    life = progress.life
    if position == len(steps) - 1:
        life = change(life, "complete")
    return replace(progress, step=steps[position], life=life)
