"""Guards the laws of a participation's life: what may follow what, and that nothing is undone."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.errors import InvalidValue
from study.protocol.lifecycle import (
    LONGEST_REASON,
    OUTCOMES,
    REASONS,
    STATUSES,
    UNDER_WAY,
    Act,
    Life,
    WrongChange,
    change,
    check_reason,
)

ACTS: tuple[Act, ...] = (*REASONS, "exclude", "reinstate")
LIVES = st.one_of(
    st.sampled_from([s for s in STATUSES if s != "excluded"]).map(Life),
    st.sampled_from([s for s in STATUSES if s not in ("excluded", "withdrawn")]).map(
        lambda before: Life("excluded", before)
    ),
)


def live(acts: list[Act]) -> list[Life]:
    """All lives met on the way; acts that do not fit change nothing."""
    lives = [Life()]
    for act in acts:
        try:
            lives.append(change(lives[-1], act))
        except WrongChange:
            lives.append(lives[-1])
    return lives


@given(st.lists(st.sampled_from(ACTS), max_size=40))
def test_a_withdrawal_is_final_and_an_end_is_only_left_by_staff_or_withdrawing(
    acts: list[Act],
) -> None:
    lives = live(acts)
    for act, before, after in zip(acts, lives, lives[1:], strict=False):
        if before.status == "withdrawn":
            assert after == before
        elif before.outcome is not None and after != before:
            assert act in ("withdraw", "exclude", "reinstate")


@given(LIVES)
def test_excluding_and_reinstating_gives_back_exactly_what_was(life: Life) -> None:
    if life.status in ("withdrawn", "excluded"):
        with pytest.raises(WrongChange):
            change(life, "exclude")
        return
    excluded = change(life, "exclude")
    assert excluded.outcome == "excluded"
    assert change(excluded, "reinstate") == life


@given(LIVES, st.sampled_from([act for act in ACTS if act not in ("exclude", "reinstate")]))
def test_saying_the_same_again_changes_nothing(life: Life, act: Act) -> None:
    try:
        once = change(life, act)
    except WrongChange:
        return
    if act in ("begin", "pause", "return", "time-out", "withdraw"):
        assert change(once, act) == once


@given(LIVES)
def test_everybody_may_withdraw_and_the_server_ends_only_what_is_under_way(life: Life) -> None:
    assert change(life, "withdraw").status == "withdrawn"
    if life.status in UNDER_WAY:
        assert change(life, "time-out").status == "timed-out"
    else:
        assert change(life, "time-out") == life
    assert (life.outcome is None) == (life.status not in OUTCOMES)


def test_who_completed_before_being_excluded_is_told_of_the_completion() -> None:
    assert change(Life("completed"), "exclude").told == "completed"
    assert change(Life("active"), "exclude").told == "excluded"


@pytest.mark.parametrize(
    ("status", "act"),
    [("completed", "complete"), ("timed-out", "begin"), ("active", "reinstate")],
)
def test_what_does_not_fit_is_refused_by_name(status: str, act: Act) -> None:
    with pytest.raises(WrongChange, match=f"“{act}” does not fit a participation that is {status}"):
        change(Life(status), act)  # type: ignore[arg-type]


def test_a_reason_is_one_short_line() -> None:
    assert check_reason("  looked \n away ") == "looked away"
    for wrong in ("", " \n", "x" * (LONGEST_REASON + 1)):
        with pytest.raises(InvalidValue, match="a reason of 1 to 200"):
            check_reason(wrong)
