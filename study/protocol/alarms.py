"""What an experimenter should be told without asking: judged from figures, with what to do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

LATE_TICK_MS = 10.0
HIGH_DROP_OUT = 0.2
FEWEST_TO_JUDGE = 5
WIDEST_SPREAD = 2
"""An alarm is raised above these figures, not at them; a share is judged from the fewest on."""
Level = Literal["problem", "warning"]


@dataclass(frozen=True)
class VitalSigns:
    """The figures of a running study, of one mode, by which it is judged.

    `storage_failing_s`: since when nothing could be stored, None if all is well; `late_p99_ms`:
    lateness that 99 % of the server's ticks stayed below; `away`: participants under way of whom
    nothing was heard for five minutes; `drop_out`: share of those past the practice who left;
    `judged`: how many that share rests on; `spread`: fullest order less emptiest.
    """

    storage_failing_s: float | None = None
    late_p99_ms: float = 0.0
    ticks: int = 0
    away: int = 0
    drop_out: float | None = None
    judged: int = 0
    spread: int = 0
    is_live: bool = False
    policy_is_simulated: bool = False
    time_scale: float = 1.0


@dataclass(frozen=True)
class Alarm:
    """What is wrong and what to do."""

    level: Level
    title: str
    advice: str


def raise_alarms(now: VitalSigns) -> list[Alarm]:
    """All alarms, the worst first."""
    return [
        alarm
        for alarm in (
            _storage(now),
            _policy(now),
            _lateness(now),
            _drop_out(now),
            _away(now),
            _balance(now),
            _time_scale(now),
        )
        if alarm is not None
    ]


def _storage(now: VitalSigns) -> Alarm | None:
    if now.storage_failing_s is None:
        return None
    return Alarm(
        "problem",
        f"Nothing could be stored for {now.storage_failing_s:.0f} s",
        "Trials go on and their data wait in memory. Do not stop the server; bring the database "
        "back or make room on its disk.",
    )


def _policy(now: VitalSigns) -> Alarm | None:
    if not (now.is_live and now.policy_is_simulated):
        return None
    return Alarm(
        "problem",
        "Live participants meet a policy that was learned from simulated people",
        "Activate a policy learned from people, or say so wherever the results are used.",
    )


def _lateness(now: VitalSigns) -> Alarm | None:
    if not now.ticks or now.late_p99_ms <= LATE_TICK_MS:
        return None
    return Alarm(
        "warning",
        f"1 % of the ticks came more than {now.late_p99_ms:.0f} ms late",
        "The machine is busy: fewer trials at the same time, or a stronger machine.",
    )


def _drop_out(now: VitalSigns) -> Alarm | None:
    if now.drop_out is None or now.judged < FEWEST_TO_JUDGE or now.drop_out <= HIGH_DROP_OUT:
        return None
    return Alarm(
        "warning",
        f"{100 * now.drop_out:.0f} % of those who passed the practice left before the end",
        "Look at where they left in the flow, and at their histories for the reasons.",
    )


def _away(now: VitalSigns) -> Alarm | None:
    if not now.away:
        return None
    who = "1 participant was" if now.away == 1 else f"{now.away} participants were"
    return Alarm(
        "warning",
        f"{who} not heard of for five minutes",
        "They keep their places until the study's limit; then the places are given back.",
    )


def _balance(now: VitalSigns) -> Alarm | None:
    if now.spread <= WIDEST_SPREAD:
        return None
    return Alarm(
        "warning",
        f"The fullest order has {now.spread} participants more than the emptiest",
        "New participants fill the emptiest orders first; recruit until they are even.",
    )


def _time_scale(now: VitalSigns) -> Alarm | None:
    if now.time_scale == 1.0:
        return None
    return Alarm(
        "warning",
        f"Worlds run {now.time_scale:g} times as fast as real time",
        "That is for trying things out; start the server without a time scale for a study.",
    )
