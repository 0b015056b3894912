"""Guards the order of steps, the practice rule, and that nothing moves a participant by mistake."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.errors import WrongStep
from study.protocol.flow import (
    FormSent,
    IdleTooLong,
    Plan,
    Progress,
    Submission,
    TrialEnded,
    UnknownStep,
    Withdrawal,
    advance,
    comes_before,
    is_trial,
    start,
    step_kind,
)
from study.protocol.lifecycle import Life

PLAN = Plan(trials=3, practice_tries=3)
STEPS = st.sampled_from([*PLAN.steps, "trial-9", "nonsense"])
SUBMISSIONS: st.SearchStrategy[Submission] = st.one_of(
    STEPS.map(FormSent),
    st.builds(TrialEnded, STEPS, st.sampled_from(["completed", "timed_out"])),
    st.just(Withdrawal()),
    st.just(IdleTooLong()),
)


def fitting(progress: Progress) -> Submission:
    if is_trial(progress.step):
        return TrialEnded(progress.step, "completed")
    return FormSent(progress.step)


def test_the_steps_come_in_the_published_order() -> None:
    progress, met = start(PLAN), []
    while progress.outcome is None:
        met.append(progress.step)
        progress = advance(PLAN, progress, fitting(progress))
    assert [*met, progress.step] == [
        "consent",
        "browser-check",
        "demographics",
        "instructions",
        "practice",
        "explanation-1",
        "trial-1",
        "questionnaire-1",
        "explanation-2",
        "trial-2",
        "questionnaire-2",
        "explanation-3",
        "trial-3",
        "questionnaire-3",
        "comments",
        "debrief",
    ]
    assert progress.outcome == "completed"
    assert progress.page == "debrief"


def test_a_failed_practice_leads_back_and_the_third_failure_ends_it() -> None:
    progress = Progress("practice")
    for tries in (1, 2):
        progress = advance(PLAN, progress, TrialEnded("practice", "timed_out"))
        assert progress == Progress("instructions", tries, Life("active"))
        progress = advance(PLAN, progress, FormSent("instructions"))
    progress = advance(PLAN, progress, TrialEnded("practice", "timed_out"))
    assert (progress.outcome, progress.page) == ("screened-out", "screened-out")


def test_a_practice_passed_at_the_last_try_counts() -> None:
    after = advance(PLAN, Progress("practice", 2), TrialEnded("practice", "completed"))
    assert after == Progress("explanation-1", 3, Life("active"))


def test_a_trial_that_ran_into_its_cap_is_still_followed_by_its_questionnaire() -> None:
    after = advance(PLAN, Progress("trial-2"), TrialEnded("trial-2", "timed_out"))
    assert after == Progress("questionnaire-2", life=Life("active"))


@pytest.mark.parametrize("step", PLAN.steps)
def test_one_may_withdraw_anywhere(step: str) -> None:
    life = Life("completed" if step == "debrief" else "active")
    assert advance(PLAN, Progress(step, life=life), Withdrawal()).outcome == "withdrawn"


@pytest.mark.parametrize("step", PLAN.steps[:-1])
def test_a_form_for_another_step_changes_nothing(step: str) -> None:
    for other in PLAN.steps:
        if other != step:
            with pytest.raises(WrongStep) as caught:
                advance(PLAN, Progress(step), FormSent(other))
            assert caught.value.current == step


def test_a_trial_step_cannot_be_left_by_a_form() -> None:
    with pytest.raises(WrongStep):
        advance(PLAN, Progress("trial-1"), FormSent("trial-1"))


def test_a_form_step_cannot_be_left_by_a_trial() -> None:
    with pytest.raises(WrongStep):
        advance(PLAN, Progress("consent"), TrialEnded("consent", "completed"))


@given(st.lists(SUBMISSIONS, max_size=60), st.integers(0, 60))
def test_whatever_is_sent_progress_is_kept_and_never_runs_backwards(
    submissions: list[Submission], fitting_first: int
) -> None:
    """Only a failed practice leads back, an outcome stays, and the tries never exceed the limit."""
    progress = start(PLAN)
    for _ in range(fitting_first):
        if progress.outcome is None:
            progress = advance(PLAN, progress, fitting(progress))
    for submission in submissions:
        before = progress
        try:
            progress = advance(PLAN, before, submission)
        except WrongStep:
            assert submission != fitting(before) or before.outcome is not None
            continue
        forward = PLAN.steps.index(progress.step) - PLAN.steps.index(before.step)
        assert forward in (0, 1) or (before.step, progress.step) == ("practice", "instructions")
        assert progress.practice_tries <= PLAN.practice_tries
        if before.outcome is not None:
            assert progress.step == before.step
            assert progress == before or progress.outcome == "withdrawn"


def test_step_ids_are_read_strictly() -> None:
    assert step_kind("trial-2") == ("trial", 2)
    assert step_kind("browser-check") == ("browser-check", None)
    for wrong in ("trial", "trial-0", "trial-", "consent-1", "", "Trial-1", "trial-1\n", "x" * 99):
        with pytest.raises(UnknownStep):
            step_kind(wrong)


def test_a_step_of_a_longer_study_is_unknown() -> None:
    with pytest.raises(UnknownStep):
        comes_before(PLAN, "trial-4", Progress("comments"))
