"""Guards the display clock: one question a second, nothing flickers."""

from dataclasses import dataclass, field

from study.ar.display import DisplayClock
from study.ar.elements import Display
from study.ar.examination import draw_situations
from study.ar.situation import ObservedWorld, Situation
from study.warehouse.layout import PRESETS, build_layout

SITUATION = next(draw_situations(build_layout(PRESETS["practice"]), 1, 1))[0]


@dataclass
class Scripted:
    """Answers with one mask per question; remembers when it was asked and what it was told."""

    masks: list[int]
    ticks: list[int] = field(default_factory=list)
    told: list[int] = field(default_factory=list)

    def decide(self, world: ObservedWorld, previous: Display) -> Display:
        mask = self.masks[min(len(self.ticks), len(self.masks) - 1)]
        self.ticks.append(world.tick)
        self.told.append(previous.robots[0])
        return Display(bytes([mask]), bytes(4))


def play(masks: list[int], ticks: int) -> tuple[Scripted, dict[int, int]]:
    """Run the clock; returns the condition and the mask by the tick from which it is shown."""
    condition = Scripted(masks)
    clock = DisplayClock(condition, 1, 4)
    world = Situation(**{**vars(SITUATION), "tick": 0})
    shown = {0: clock.start(world).robots[0]}
    for tick in range(1, ticks + 1):
        world.tick = tick
        changed = clock.update(world)
        if changed is not None:
            assert changed == clock.display
            shown[tick] = changed.robots[0]
    return condition, shown


def test_one_question_a_second() -> None:
    """Asked at the start and then every 30th tick."""
    condition, _ = play([0], 95)
    assert condition.ticks == [0, 30, 60, 90]


def test_an_element_holds_for_two_seconds() -> None:
    """A wish after one second waits until two have passed."""
    assert play([1, 0, 0, 1, 1, 1], 150)[1] == {0: 1, 60: 0, 120: 1}


def test_a_withdrawn_wish_changes_nothing() -> None:
    """On, off after a second, on again: it stays on."""
    assert play([1, 0, 1, 1], 90)[1] == {0: 1}


def test_elements_hold_each_for_itself() -> None:
    """Bit 2 may go at 60 although bit 1 changed at 30 ticks less."""
    assert play([3, 3, 1, 2, 2, 2, 2], 180)[1] == {0: 3, 60: 1, 90: 0, 120: 2}


def test_the_condition_is_told_what_was_shown_not_what_it_wished() -> None:
    """nearbyRobotVizStatus depends on the display after the previous decision."""
    condition, _ = play([1, 0, 0], 90)
    assert condition.told == [0, 1, 1, 0]
