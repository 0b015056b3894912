"""Guards learning sessions: what experts may do, who leads, and whose boxes count."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from study.errors import InvalidValue, JournalError, StudyError, WrongMoment
from study.learning.policy_up import Version
from study.learning.session import Entry, LearningSession, begin_session
from study.learning.settings import LearningSettings
from study.records.events import check_event
from tests.study.learning.moments import AGENTS, moment

ANNA, BEN, CLEO = "a" * 16, "b" * 16, "c" * 16
NAMES = {ANNA: "anna", BEN: "ben", CLEO: "cleo"}


def fresh(**changes: Any) -> LearningSession:
    """A session at its first tick."""
    session = begin_session(LearningSettings(iterations=12, **changes), AGENTS)
    session.up.begin_trial(5)
    session.start(moment(0))
    return session


def run(session: LearningSession, first: int, last: int) -> None:
    for tick in range(first, last + 1):
        session.update(moment(tick))


def kinds(entries: tuple[Entry, ...]) -> list[str]:
    return [kind for kind, _ in entries]


def test_pairs_are_taken_only_while_the_lead_is_connected() -> None:
    """Nobody there: none; another expert alone: none; the lead: 10 at each snapshot."""
    session = fresh()
    run(session, 1, 120)
    assert kinds(session.join("anna", ANNA)) == ["expert_joined", "lead_changed"]
    run(session, 121, 240)
    assert kinds(session.join("ben", BEN)) == ["expert_joined"]
    session.leave(ANNA)
    run(session, 241, 360)
    session.join("anna", ANNA)
    run(session, 361, 480)
    assert sorted({pair.tick for _, pair in session.take_pairs()}) == [240, 480]
    assert session.take_pairs() == []


def test_the_lead_is_taken_only_when_nobody_connected_has_it() -> None:
    session = fresh()
    session.join("anna", ANNA)
    session.join("ben", BEN)
    with pytest.raises(WrongMoment, match="anna leads"):
        session.take_lead(BEN)
    session.leave(ANNA)
    assert kinds(session.take_lead(BEN)) == ["lead_changed"]
    assert session.take_lead(BEN) == ()
    session.join("anna", ANNA)
    assert session.panel.lead == BEN
    with pytest.raises(WrongMoment, match="only the expert who leads"):
        session.hand_over(ANNA, BEN)
    with pytest.raises(WrongMoment, match="not connected"):
        session.hand_over(BEN, CLEO)


def test_who_leads_and_loads_the_page_again_leads_on() -> None:
    """The new page has another number; somebody else's page does not get the lead by coming."""
    session = fresh()
    session.join("anna", ANNA)
    session.edit(ANNA, 1, [(0, 0, 7)])
    session.leave(ANNA)
    assert kinds(session.join("ben", BEN)) == ["expert_joined"]
    assert kinds(session.join("anna", CLEO)) == ["expert_joined", "lead_changed"]
    assert session.boxes_of(CLEO).masks[0] == 0


def test_who_hands_over_goes_on_with_a_copy_of_the_boxes() -> None:
    """The run's boxes stay as they are; what the former lead sets then no longer counts."""
    session = fresh(box_mode="independent")
    session.join("anna", ANNA)
    session.join("ben", BEN)
    session.edit(ANNA, 1, [(0, 0, 7)])
    session.edit(BEN, 1, [(0, 0, 1), (1, 0, 7)])
    assert session.up.boxes.masks[:2] == [0, 7]
    assert session.boxes_of(BEN).masks[:2] == [6, 0]
    session.hand_over(ANNA, BEN)
    assert session.boxes_of(BEN) is session.up.boxes
    assert session.boxes_of(ANNA).masks[:2] == [0, 7]
    session.edit(ANNA, 2, [(2, 0, 7)])
    session.edit(BEN, 2, [(3, 0, 7)])
    assert session.up.boxes.masks[:4] == [0, 7, 7, 0]


def test_the_others_are_compared_at_snapshots_and_at_home_robots_are_left_out() -> None:
    session = fresh(box_mode="independent")
    for page in (ANNA, BEN):
        session.join(NAMES[page], page)
    session.edit(BEN, 1, [(1, 0, 2)])
    session.update(moment(120, (0, 3, 6, 0, 0, 0)))
    rated = session.take_settings()
    assert [entry.agent for entry in rated] == [0, 1, 3, 4, 5, 6, 7, 8, 9]
    assert {entry.expert for entry in rated} == {"ben"}
    assert rated[1][3:] == (1, 5, 7, 1)
    assert session.take_settings() == []


Act = Callable[[LearningSession], object]


@pytest.mark.parametrize(
    ("act", "kind", "says"),
    [
        (lambda s: s.edit(ANNA, 2, [(0, 0, 1), (10, 1, 0)]), InvalidValue, "no agent 10"),
        (lambda s: s.edit(ANNA, 2, [(0, 0, 1), (-1, 1, 0)]), InvalidValue, "no agent -1"),
        (lambda s: s.edit(ANNA, 2, [(0, 0, 1), (6, 2, 0)]), InvalidValue, "agent 6 has no boxes"),
        (lambda s: s.edit(ANNA, 2, [(0, 1, 1)]), InvalidValue, "agent 0"),
        (lambda s: s.confirm(ANNA, 2, [0, 99]), InvalidValue, "no agent 99"),
        (lambda s: s.edit(CLEO, 1, [(0, 0, 1)]), JournalError, "without having joined"),
        (lambda s: s.check_moment(1, 0), WrongMoment, "trial 2 is not the present one"),
        (lambda s: s.check_moment(0, 31), WrongMoment, "tick 31 has not come yet"),
        (lambda s: s.join("ben", ANNA), WrongMoment, "another account"),
    ],
)
def test_what_cannot_be_is_refused_whole(act: Act, kind: type[StudyError], says: str) -> None:
    """An error changes nothing, also of the parts that would have been right."""
    session = fresh()
    session.join("anna", ANNA)
    session.edit(ANNA, 1, [(4, 0, 4)])
    run(session, 1, 30)
    before = session.to_json()
    with pytest.raises(kind, match=says):
        act(session)
    assert session.to_json() == before


def test_a_message_that_comes_twice_is_taken_once() -> None:
    session = fresh()
    session.join("anna", ANNA)
    assert kinds(session.edit(ANNA, 3, [(0, 0, 1), (1, 0, 1)])) == ["expert_set"] * 2
    assert session.edit(ANNA, 3, [(2, 0, 1)]) == session.confirm(ANNA, 2, [0]) == ()
    assert session.up.boxes.masks[:3] == [6, 6, 7]
    assert session.panel.taken_seq(ANNA) == 3
    session.leave(ANNA)
    session.join("anna", ANNA)
    assert session.edit(ANNA, 3, [(2, 0, 1)]) == ()


def test_one_gesture_may_touch_an_agent_twice() -> None:
    session = fresh()
    session.join("anna", ANNA)
    ((_, data),) = session.edit(ANNA, 1, [(0, 0, 3), (0, 1, 4)])
    assert data["mask"] == 1


def test_every_entry_is_in_the_data_dictionary() -> None:
    session = fresh()
    entries = [*session.join("anna", ANNA), *session.join("ben", BEN)]
    entries += [*session.edit(ANNA, 1, [(0, 0, 1)]), *session.confirm(ANNA, 2, [1])]
    entries += [*session.hand_over(ANNA, BEN), *session.leave(ANNA)]
    session.up.j = 1
    session.offer(Version(1, session.up.latest, ""), "f" * 64)
    run(session, 1, 30)
    entries += session.take_entries()
    for kind, data in entries:
        check_event(kind, data)
    assert {kind for kind, _ in entries} == {
        "expert_joined", "expert_left", "lead_changed", "expert_set", "expert_confirmed",
        "policy_replaced",
    }  # fmt: skip


def test_policies_come_in_order_and_at_decisions_only() -> None:
    session = fresh()
    session.up.j = 3
    session.offer(Version(2, session.up.latest, "b"), "2" * 64)
    run(session, 1, 30)
    assert session.take_entries() == []
    session.offer(Version(1, session.up.latest, "a"), "1" * 64)
    run(session, 31, 59)
    assert session.take_entries() == []
    run(session, 60, 60)
    assert [data["policy_sha256"][0] for _, data in session.take_entries()] == ["1", "2"]


def test_an_entry_that_cannot_be_is_refused() -> None:
    session = fresh()
    session.join("anna", ANNA)
    message = {"expert": "anna", "client": ANNA, "seq": 1, "agent": 15, "mask": 1}
    with pytest.raises(JournalError, match="nothing an expert does"):
        session.apply("paused", message)
    with pytest.raises(InvalidValue, match="no agent"):
        session.apply("expert_set", message)
