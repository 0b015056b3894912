"""Guards that an explanation shows exactly what its condition can show."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from study.ar.conditions import CONDITIONS, build_condition
from study.ar.elements import Display, Element, Overlay
from study.protocol.displays import SHOWN, display_label

NAMES = {
    Element.TRAJECTORY: "trajectory",
    Element.LIVE_LOCATION: "live-location",
    Element.TRANSPARENT_AVATAR: "transparent-avatar",
    Element.PATH_BEADS: "path-beads",
}
OVERLAYS = {Overlay.MINIMAP: "minimap", Overlay.OFFSCREEN_ARROWS: "offscreen-arrows"}


def names_of(display: Display) -> set[str]:
    names = {name for bit, name in NAMES.items() if display.robots[0] & bit}
    names |= {name for bit, name in OVERLAYS.items() if display.overlays & bit}
    return names | ({"balloon"} if display.stations[0] else set())


def test_every_condition_is_explained() -> None:
    assert set(SHOWN) == set(CONDITIONS)


@pytest.mark.parametrize("name", ["arroch", "crmiar", "none", "full"])
def test_a_steady_condition_is_explained_by_what_it_decides(name: str) -> None:
    world = SimpleNamespace(robot_x_m=[0.0], layout=SimpleNamespace(stations=[0]))
    decided = build_condition(name).decide(world, Display.nothing(1, 1))  # type: ignore[arg-type]
    assert set(SHOWN[name].names) == names_of(decided)
    assert not SHOWN[name].adaptive


def test_the_learned_display_is_explained_by_all_that_a_policy_can_switch() -> None:
    assert SHOWN["varil"].adaptive
    assert set(SHOWN["varil"].names) == set(SHOWN["full"].names)


def test_participants_meet_letters() -> None:
    assert [display_label(k) for k in (1, 2, 3)] == ["Display A", "Display B", "Display C"]
