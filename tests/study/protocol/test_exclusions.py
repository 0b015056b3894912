"""Guards exclusion rules: what lies beyond a bound is flagged, what was not measured never is."""

from __future__ import annotations

import pytest

from study.protocol.exclusions import ExclusionRule, flag_participant, flag_trial, take_together

AWAY = ExclusionRule(name="away", measure="hidden_s", above=20)
SLOW = ExclusionRule(name="slow", measure="frame_rate_median_hz", below=20, per="participant")
OFTEN = ExclusionRule(name="often", measure="pauses", above=2, per="participant")
RULES = (AWAY, SLOW, OFTEN)


@pytest.mark.parametrize(
    ("hidden_s", "flags"), [(20.0, []), (20.1, ["away"]), (None, []), (0.0, [])]
)
def test_a_trial_is_flagged_beyond_the_bound_only(hidden_s: float | None, flags: list[str]) -> None:
    assert flag_trial(RULES, {"hidden_s": hidden_s, "pauses": 9}) == flags


def test_a_participant_is_judged_by_all_trials_together() -> None:
    trials = [
        {"frame_rate_median_hz": 10.0, "pauses": 1, "hidden_s": 99.0},
        {"frame_rate_median_hz": 30.0, "pauses": 1},
        {"frame_rate_median_hz": 31.0, "pauses": None},
    ]
    assert flag_participant(RULES, trials) == []
    assert flag_participant(RULES, [*trials, {"pauses": 1}]) == ["often"]
    assert flag_participant(RULES, [trials[0]]) == ["slow"]
    assert flag_participant(RULES, []) == []


def test_figures_are_taken_together_as_the_measure_says() -> None:
    trials = [{"rtt_p95_ms": 5.0, "frame_rate_p5_hz": 9.0}, {"rtt_p95_ms": 8.0}]
    assert take_together("rtt_p95_ms", trials) == 8.0
    assert take_together("frame_rate_p5_hz", [*trials, {"frame_rate_p5_hz": 4.0}]) == 4.0
    assert take_together("idle_s", trials) is None


def test_a_rule_says_itself_in_words() -> None:
    assert AWAY.sentence == "hidden_s above 20 s (per trial)"
    assert OFTEN.sentence == "pauses above 2 (per participant)"
