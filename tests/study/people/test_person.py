"""Guards the expert `person`: it judges what can be seen, is as slow as it says, and slips."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from study.ar.elements import Display
from study.learning.boxes import NEVER, Checkboxes
from study.learning.policy_up import PolicyUp
from study.learning.settings import LearningSettings
from study.people.beliefs import ARRIVES, BUSY, GONE, UNKNOWN, WAITS
from study.people.habits import Habits
from study.people.learning_run import run_learning
from study.people.parameters import parameters_of
from study.people.person import Person
from study.people.wishes import Impression, Wish, misjudge, wish_robot, wish_station
from study.warehouse.layout import PRESETS, build_layout
from study.warehouse.state import RobotState
from study.warehouse.world import World

VALUES = parameters_of("expert")
FAR = Impression(BUSY, True, False, True, False, True, 12.0, 30.0, 0.0)
NOTHING = Display.nothing(12, 4)
ALL_ON = Display(bytes([7] * 12), bytes([1] * 4))


def world_at(tick: int) -> World:
    """A study hall whose worker stands still at its start."""
    world = World(build_layout(PRESETS["study"]), 5)
    for _ in range(tick):
        world.step([])
    return world


def wishes_of(world: World, habits: Habits, display: Display) -> list[Wish]:
    """What a fresh person wants at its first look."""
    person = Person(3, habits)
    person.act(world, display, Checkboxes(12, 4, follow=True), world.tick)
    assert person._picture is not None
    person._picture.look(display)
    return person._picture.wishes(habits.wish, person.values)


@pytest.mark.parametrize(
    ("rule", "change", "wanted"),
    [
        ("declutter", {"kind": WAITS}, (1, 7, True)),
        ("declutter", {"kind": WAITS, "direct": True}, (1, 7, True)),
        ("declutter", {"kind": WAITS, "direct": True, "away_m": 5.9}, (0, 7, True)),
        ("declutter", {"kind": WAITS, "away_m": 5.9}, (1, 7, True)),
        ("declutter", {"kind": WAITS, "crowded": True}, (1, 7, True)),
        ("declutter", {"kind": WAITS, "crowded": True, "longest": False}, (0, 7, True)),
        ("declutter", {"kind": ARRIVES, "left_s": 15.0}, (5, 7, True)),
        ("declutter", {"kind": ARRIVES, "left_s": 15.0, "away_m": 5.9}, (4, 7, True)),
        ("declutter", {"kind": ARRIVES, "left_s": 9.0, "crowded": True}, (3, 7, True)),
        ("declutter", {"kind": ARRIVES, "left_s": 15.1}, (0, 7, False)),
        ("declutter", {"kind": BUSY}, (0, 7, False)),
        ("inform", {"kind": BUSY}, (4, 7, False)),
        ("inform", {"kind": ARRIVES, "left_s": 15.1}, (4, 7, False)),
        ("inform", {"kind": WAITS}, (1, 7, True)),
        ("inform", {"kind": GONE}, (0, 7, False)),
        ("inform", {"kind": WAITS, "known": False, "unseen_s": 20.0}, (0, 0, False)),
        ("inform", {"kind": UNKNOWN, "known": False, "unseen_s": 20.1}, (1, 1, False)),
    ],
)
def test_wishes_follow_the_published_rules(
    rule: str, change: dict[str, object], wanted: tuple[int, int, bool]
) -> None:
    assert tuple(wish_robot(rule, FAR._replace(**change), VALUES)) == wanted


def test_balloons_are_wanted_where_somebody_waits_and_the_worker_is_not() -> None:
    assert wish_station(True, True, False).on == 1
    assert wish_station(True, True, True).on == 0
    assert wish_station(True, False, False).on == 0
    assert wish_station(False, True, False).about == 0


@pytest.mark.parametrize(("view", "may_change"), [("worker", False), ("above", True)])
def test_what_cannot_be_seen_changes_nothing(view: str, may_change: bool) -> None:
    """With nothing displayed, robots behind shelves could do anything: no wish depends on it.

    From above no shelf hides them.
    """
    habits = Habits(view=view)
    world = world_at(450)
    before = wishes_of(world, habits, NOTHING)
    seen = Person(3, Habits(view="worker"))
    seen.act(world, NOTHING, Checkboxes(12, 4, follow=True), 0)
    assert seen._picture is not None
    hidden = np.flatnonzero(seen._picture.seen["known"] == 0)
    assert 0 < len(hidden) < 12
    for robot in hidden:
        world.motion.robots["state"][robot] = RobotState.WAITING
        world.motion.robots["carrying"][robot] = 2
        world.motion.robots["station"][robot] = 1
    assert (wishes_of(world, habits, NOTHING) != before) == may_change


def test_avatars_tell_what_shelves_hide() -> None:
    """The worker's view knows more robots when they are displayed, and all from above."""
    world = world_at(450)
    known = [
        sum(wish.about == 7 for wish in wishes_of(world, Habits(view=view), display))
        for view, display in (("worker", NOTHING), ("worker", ALL_ON), ("above", NOTHING))
    ]
    assert known[0] < known[1] <= known[2] == 12


def test_a_lost_robot_is_looked_for_after_a_while() -> None:
    """Who was never seen is left alone for 20 s; then its live location is wanted, no more."""
    early, late = world_at(570), world_at(630)
    assert {wish.about for wish in wishes_of(early, Habits(), NOTHING)[:12]} <= {0, 7}
    lost = [wish for wish in wishes_of(late, Habits(), NOTHING)[:12] if wish.about == 1]
    assert lost
    assert {wish.on for wish in lost} == {1}


def test_it_clicks_one_box_after_the_other_at_human_speed() -> None:
    """A first box takes 2.95 s, each further one of its row 1 s more; never two at once."""
    world, person = world_at(0), Person(1, Habits(view="above"))
    boxes = Checkboxes(12, 4, follow=True)
    last, row, edits = 0, -1, 0
    for _ in range(1800):
        before = list(boxes.masks)
        person.act(world, ALL_ON, boxes, world.tick)
        changed = [n for n, mask in enumerate(before) if mask != boxes.masks[n]]
        assert len(changed) <= 1
        if changed:
            waited = world.tick - last
            assert waited >= (30 if changed[0] == row else 89)
            last, row, edits = world.tick, changed[0], edits + 1
            assert (before[row] ^ boxes.masks[row]).bit_count() == 1
        world.step([])
    assert 15 < edits < 60


def test_a_slip_hits_the_row_beside() -> None:
    """With every click a slip, each hits the same box one row above or below."""
    world = world_at(0)
    person = Person(1, Habits(view="above", replaced=(("expert.wrong_box", 1.0),)))
    boxes = Checkboxes(12, 4, follow=True)
    slips = 0
    for _ in range(900):
        meant = person._clicks[0] if person._clicks else None
        before = list(boxes.masks)
        person.act(world, ALL_ON, boxes, world.tick)
        changed = [n for n, mask in enumerate(before) if mask != boxes.masks[n]]
        if changed:
            assert meant is not None
            assert abs(changed[0] - meant[1]) == 1
            assert before[changed[0]] ^ boxes.masks[changed[0]] == meant[2]
            slips += 1
        world.step([])
    assert slips > 5


def test_a_misjudged_status_leads_to_another_wish() -> None:
    assert [misjudge(kind) for kind in (WAITS, ARRIVES, BUSY, GONE)] == [BUSY, BUSY, WAITS, WAITS]
    layout = build_layout(PRESETS["small"])
    settings = LearningSettings(iterations=8, seed=3)
    blind = Habits(replaced=(("expert.misjudge", 1.0),))
    runs = [run_learning(settings, layout, "cyclic", "person", None, h) for h in (None, blind)]
    assert runs[0].dataset.pairs != runs[1].dataset.pairs


@pytest.mark.parametrize("replaced", ["expert.near_m", "expert.soon_s", "expert.point_s"])
def test_habits_change_what_is_learned(replaced: str) -> None:
    """A doubled parameter of the expert reaches it; a run without habits has the defaults."""
    layout = build_layout(PRESETS["small"])
    settings = LearningSettings(iterations=12, seed=2)

    def run(habits: Habits | None) -> PolicyUp:
        return run_learning(settings, layout, "cyclic", "person", habits=habits)

    default = run(None)
    assert run(Habits().scaled([replaced], 2.0)).dataset.pairs != default.dataset.pairs
    assert run(Habits()).dataset.pairs == default.dataset.pairs


def test_wishes_and_views_make_different_runs() -> None:
    layout = build_layout(PRESETS["small"])
    settings = LearningSettings(iterations=8, seed=2)
    hashes = {
        run_learning(
            settings, layout, "cyclic", "person", habits=Habits(wish=wish, view=view)
        ).dataset.sha256()
        for wish in ("declutter", "inform")
        for view in ("worker", "above")
    }
    assert len(hashes) == 4


@pytest.mark.parametrize("source", ["events", "confirmed"])
def test_it_gives_labels_from_what_it_did(source: str) -> None:
    """Only what was touched is learned; a person who is asked to confirm does so when free."""
    layout = build_layout(PRESETS["small"])
    settings = LearningSettings(iterations=4, label_source=source)
    up = run_learning(settings, layout, "cyclic", "person", habits=Habits(view="above"))
    assert up.units == 100
    confirmed = any(tick != NEVER for tick in up.boxes.confirmed)
    assert confirmed == (source == "confirmed")


def test_a_new_trial_begins_with_nothing_known() -> None:
    """Clicks that were planned and robots that were seen stay behind in the trial that ended."""
    world, person = world_at(0), Person(1, Habits(view="above"))
    boxes = Checkboxes(12, 4, follow=True)
    for _ in range(60):
        person.act(world, ALL_ON, boxes, world.tick)
        world.step([])
    assert person._clicks
    masks = copy.copy(boxes.masks)
    fresh = world_at(0)
    person.act(fresh, ALL_ON, boxes, 200)
    assert boxes.masks == masks
    assert all(click[0] >= 50 for click in person._clicks)
