"""Guards the flow of participants: nobody is lost between its boxes; who dropped out is told."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.protocol.consort import STAGES, Crowd, count_drop_out, count_flow, stage_of
from study.protocol.flow import Plan, UnknownStep
from study.protocol.lifecycle import UNDER_WAY, Status

TRIALS = 3
STEPS = Plan(TRIALS, 3, frozenset()).steps
EARLY: tuple[Status, ...] = ("withdrawn", "timed-out", "excluded")


@st.composite
def crowds(draw: st.DrawFn) -> Crowd:
    """So many who stand somewhere they can stand: `debrief` is for those who completed."""
    step = draw(st.sampled_from(STEPS))
    ends: tuple[Status, ...] = (*UNDER_WAY, *EARLY)
    if step == "debrief":
        ends = ("completed", "withdrawn", "excluded")
    elif step == "practice":
        ends = (*ends, "screened-out")
    status = draw(st.sampled_from(ends))
    before: Status | None = "active" if status == "excluded" else None
    return Crowd("live", status, before, step, None, draw(st.integers(1, 1000)))


def crowd(step: str, status: Status, number: int = 1) -> Crowd:
    return Crowd("live", status, None, step, None, number)


@given(st.lists(crowds(), max_size=12))
def test_the_boxes_add_up(groups: list[Crowd]) -> None:
    """Who reached a stage is there, left from it or reached the next; the last rest is analysed."""
    flow = count_flow(groups, TRIALS)
    assert [stage.name for stage in flow.stages] == [name for name, _ in STAGES]
    assert flow.joined == sum(group.number for group in groups)
    onward = [stage.reached for stage in flow.stages[1:]] + [flow.analysed]
    for stage, next_reached in zip(flow.stages, onward, strict=True):
        assert stage.reached == stage.present + stage.left_in_all + next_reached
    assert flow.analysed == sum(g.number for g in groups if g.status == "completed")


@given(st.lists(crowds(), max_size=8), st.randoms(use_true_random=False))
def test_groups_may_come_in_any_order_and_in_pieces(groups: list[Crowd], random: object) -> None:
    """The same people, one by one and shuffled, make the same flow."""
    pieces = [crowd(g.step, g.status) for g in groups for _ in range(min(g.number, 5))]
    whole = [crowd(g.step, g.status, min(g.number, 5)) for g in groups]
    random.shuffle(pieces)  # type: ignore[attr-defined]
    assert count_flow(pieces, TRIALS) == count_flow(whole, TRIALS)


def test_stages_follow_the_steps() -> None:
    """Along the way nobody falls back a stage, and each stage begins where its heading says."""
    stages = [stage_of(step, TRIALS) for step in STEPS]
    assert stages == sorted(stages)
    first = {STAGES[stage][0]: STEPS[stages.index(stage)] for stage in sorted(set(stages))}
    assert first == {
        "joined": "consent",
        "consented": "browser-check",
        "checked": "demographics",
        "practised": "explanation-1",
        "played": "questionnaire-3",
        "completed": "debrief",
    }
    with pytest.raises(UnknownStep):
        stage_of("tea-break", TRIALS)


def test_those_who_left_are_named_by_how_in_a_fixed_order() -> None:
    flow = count_flow(
        [
            crowd("trial-1", "timed-out", 2),
            crowd("trial-2", "withdrawn"),
            crowd("consent", "joined"),
        ],
        TRIALS,
    )
    practised = flow.stages[3]
    assert practised.left == (("withdrawn", 1), ("timed-out", 2))
    assert (practised.reached, practised.left_in_all, flow.stages[0].present) == (3, 3, 1)


def test_the_drop_out_counts_who_left_between_practice_and_end() -> None:
    """Not those before the practice, under way or excluded; a late withdrawal reached the end."""
    groups = [
        crowd("practice", "screened-out", 50),
        crowd("trial-2", "active", 50),
        crowd("trial-2", "excluded", 50),
        crowd("debrief", "excluded", 50),
        crowd("trial-1", "timed-out", 2),
        crowd("comments", "withdrawn", 1),
        crowd("debrief", "completed", 8),
        crowd("debrief", "withdrawn", 1),
    ]
    found = count_drop_out(count_flow(groups, TRIALS))
    assert (found.gone, found.judged, found.share) == (3, 12, 0.25)
    assert count_drop_out(count_flow([], TRIALS)).share is None
    assert count_drop_out(count_flow(groups[:4], TRIALS)).share is None
