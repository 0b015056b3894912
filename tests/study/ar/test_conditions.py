"""Guards the conditions: what each shows, and that all pass the examination."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from study.ar.conditions import CONDITIONS, Condition, Varil, build_condition
from study.ar.elements import Display
from study.ar.examination import ExaminationFailed, draw_situations, examine_condition
from study.ar.situation import ObservedWorld
from study.ar.states import robot_states, station_states
from study.ar.thresholds import Thresholds
from study.errors import PolicyError, UnknownCondition
from study.learning.policy import Policy, initial_policy
from study.warehouse.layout import PRESETS, build_layout

LAYOUT = build_layout(PRESETS["study"])


def random_policy(seed: int) -> Policy:
    draws = np.random.default_rng(seed)
    return Policy(
        "random",
        "simulated",
        Thresholds(),
        tuple(draws.integers(0, 8, 144).tolist()),
        tuple(draws.integers(0, 2, 18).tolist()),
    )


@pytest.mark.parametrize("name", CONDITIONS)
def test_conditions_pass_the_examination(name: str) -> None:
    """Every condition of the registry keeps the contract, a learned policy included."""
    assert examine_condition(lambda: build_condition(name, initial_policy())) == 100
    assert examine_condition(lambda: build_condition(name, random_policy(3))) == 100


@pytest.mark.parametrize(
    ("name", "robot", "balloon", "overlays"),
    [
        ("arroch", 7, 0, 0),
        ("crmiar", 12, 0, 3),
        ("none", 0, 0, 0),
        ("full", 7, 1, 0),
        ("varil", 7, 1, 0),
    ],
)
def test_what_each_condition_shows(name: str, robot: int, balloon: int, overlays: int) -> None:
    """As tabled: ARROCH without balloons, CRMIAR without see-through avatars, VARIL's start."""
    situation, previous = next(draw_situations(LAYOUT, 1, 1))
    shown = build_condition(name, initial_policy()).decide(situation, previous)
    assert shown == Display(bytes([robot] * 12), bytes([balloon] * 4), overlays)


def test_varil_looks_each_agents_state_up() -> None:
    """Per agent: action = table[own state], nothing else."""
    policy = random_policy(7)
    for situation, previous in draw_situations(LAYOUT, 5, 20):
        shown = Varil(policy).decide(situation, previous)
        states = robot_states(situation, previous, policy.thresholds)
        stations = station_states(situation, policy.thresholds)
        assert list(shown.robots) == [policy.robot_table[s] for s in states]
        assert list(shown.stations) == [policy.station_table[s] for s in stations]


def test_execution_is_decentralised() -> None:
    """Changing all other agents' private values leaves an agent's own action as it was."""
    policy = random_policy(11)
    changed_others = 0
    for situation, previous in draw_situations(LAYOUT, 9, 20):
        before = Varil(policy).decide(situation, previous)
        for values in (situation.robot_carrying, situation.robot_remaining):
            values[1:] = 2 - values[1:]
        situation.robot_wait_s[1:] += 40.0
        after = Varil(policy).decide(situation, previous)
        assert after.robots[0] == before.robots[0]
        changed_others += after.robots[1:] != before.robots[1:]
    assert changed_others > 10, "the change must have mattered to the others"


def test_unknown_condition_is_named() -> None:
    with pytest.raises(UnknownCondition, match=r"no condition “vrail”.*varil, arroch"):
        build_condition("vrail")


def test_varil_without_a_policy_says_what_to_do() -> None:
    with pytest.raises(PolicyError, match=r"none was given.*policy file"):
        build_condition("varil")


@dataclass
class Flawed:
    """A condition broken in one way."""

    answer: Callable[[ObservedWorld, Display, list[int]], Display]
    asked: list[int] = field(default_factory=list)

    def decide(self, world: ObservedWorld, previous: Display) -> Display:
        self.asked.append(1)
        return self.answer(world, previous, self.asked)


def fill(world: ObservedWorld, mask: int, balloon: int = 0, overlays: int = 0) -> Display:
    return Display(bytes([mask] * len(world.robot_x_m)), bytes([balloon] * 4), overlays)


FLAWS: dict[str, tuple[Callable[[ObservedWorld, Display, list[int]], Display], str]] = {
    "a robot too few": (lambda w, p, n: Display(bytes(len(w.robot_x_m) - 1), bytes(4)), "masks"),
    "unknown element": (lambda w, p, n: fill(w, 16), "unknown element"),
    "unknown overlay": (lambda w, p, n: fill(w, 1, overlays=4), "unknown overlay"),
    "balloon of 2": (lambda w, p, n: fill(w, 1, balloon=2), "neither 0 nor 1"),
    "counts its questions": (lambda w, p, n: fill(w, len(n) % 8), "answers otherwise"),
    "central decision": (lambda w, p, n: fill(w, int(w.robot_remaining.sum()) % 8), "others show"),
    "shared wait": (lambda w, p, n: fill(w, 0, int(w.robot_wait_s.max() > 44.0)), "balloon"),
}


@pytest.mark.parametrize("flaw", FLAWS)
def test_the_examination_finds_flaws(flaw: str) -> None:
    """An examination that lets everything pass would be worth nothing."""
    answer, complaint = FLAWS[flaw]
    with pytest.raises(ExaminationFailed, match=complaint):
        examine_condition(lambda: build_flawed(answer))


def build_flawed(answer: Callable[[ObservedWorld, Display, list[int]], Display]) -> Condition:
    return Flawed(answer)
