"""Guards the expert's checkboxes in both modes."""

from __future__ import annotations

from study.learning.boxes import NEVER, Checkboxes


def test_a_following_box_takes_what_changed_and_keeps_the_rest() -> None:
    boxes = Checkboxes(1, 1, follow=True)
    boxes.set(0, 0b001, tick=10)
    boxes.propose([0b101, 1])  # the ghost's bit changed to off; live and trajectory did not
    assert boxes.masks == [0b001, 1]
    boxes.propose([0b111, 0])
    assert boxes.masks == [0b011, 0]


def test_an_independent_box_keeps_the_experts_setting() -> None:
    boxes = Checkboxes(2, 1, follow=False)
    boxes.set(1, 0b100, tick=3)
    boxes.propose([0, 0, 0])
    assert boxes.masks == [7, 4, 1]
    assert boxes.proposals == [0, 0, 0]


def test_ages_tell_edits_from_confirmations() -> None:
    boxes = Checkboxes(1, 1, follow=True)
    assert boxes.edit_age(0, 50) == NEVER
    boxes.set(0, 7, tick=20)
    assert not boxes.was_edited(0, 30, within=240)
    assert boxes.was_confirmed(0, 30, within=240)
    boxes.set(0, 3, tick=40)
    assert boxes.edit_age(0, 50) == 10
    assert boxes.was_edited(0, 280, within=240)
    assert not boxes.was_edited(0, 281, within=240)


def test_elements_an_agent_does_not_have_stay_off() -> None:
    boxes = Checkboxes(1, 1, follow=True)
    boxes.set(1, 7, tick=0)
    boxes.set(0, 15, tick=0)
    assert boxes.masks == [7, 1]
