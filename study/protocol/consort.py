"""How many got how far: the flow of participants as CONSORT reports draw it, with who left where.

Counted from groups of participants (status, status before an exclusion, step), never from single
people, so that a thousand of them cost no more than ten.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from study.protocol.flow import step_kind
from study.protocol.lifecycle import UNDER_WAY, Status

STAGES = (
    ("joined", "Joined"),
    ("consented", "Consented"),
    ("checked", "Passed the device check"),
    ("practised", "Passed the practice"),
    ("played", "Played every trial"),
    ("completed", "Completed"),
)
"""Name and heading of each stage; whoever reaches one has reached all before it."""
LEFT: tuple[Status, ...] = ("withdrawn", "screened-out", "timed-out", "excluded")
_REACHED = {"consent": 0, "browser-check": 1, "demographics": 2, "instructions": 2, "practice": 2}
_IN_TRIALS, _PLAYED, _COMPLETED = 3, 4, 5


@dataclass(frozen=True)
class Crowd:
    """So many participants of one mode who stand alike."""

    mode: str
    status: Status
    before: Status | None
    step: str
    order_index: int | None
    number: int

    @property
    def is_under_way(self) -> bool:
        """Whether they may still complete."""
        return self.status in UNDER_WAY


@dataclass(frozen=True)
class Stage:
    """One box of the flow: who reached it, who is there now, and who left from there and how."""

    name: str
    heading: str
    reached: int
    present: int
    left: tuple[tuple[str, int], ...]

    @property
    def left_in_all(self) -> int:
        """How many left from here."""
        return sum(number for _, number in self.left)


@dataclass(frozen=True)
class ParticipantFlow:
    """The stages in order, and how many of those who completed count in the analysis."""

    stages: tuple[Stage, ...]
    analysed: int

    @property
    def joined(self) -> int:
        """Everybody."""
        return self.stages[0].reached


def count_flow(crowds: Iterable[Crowd], trials: int) -> ParticipantFlow:
    """The flow of these participants through a study with so many trials."""
    reached: Counter[int] = Counter()
    present: Counter[int] = Counter()
    left: dict[int, Counter[str]] = {k: Counter() for k in range(len(STAGES))}
    analysed = 0
    for crowd in crowds:
        stage = stage_of(crowd.step, trials)
        for earlier in range(stage + 1):
            reached[earlier] += crowd.number
        if crowd.status == "completed":
            analysed += crowd.number
        elif crowd.is_under_way:
            present[stage] += crowd.number
        else:
            left[stage][crowd.status] += crowd.number
    stages = tuple(
        Stage(name, heading, reached[k], present[k], tuple(_in_order(left[k])))
        for k, (name, heading) in enumerate(STAGES)
    )
    return ParticipantFlow(stages, analysed)


def stage_of(step: str, trials: int) -> int:
    """Index of the last stage that somebody at this step has reached."""
    kind, position = step_kind(step)
    if kind in _REACHED:
        return _REACHED[kind]
    if kind == "debrief":
        return _COMPLETED
    if kind in ("final", "comments") or (kind == "questionnaire" and position == trials):
        return _PLAYED
    return _IN_TRIALS


def drop_out_share(flow: ParticipantFlow) -> float | None:
    """Of those who passed the practice and are no longer under way, the share that left before the
    end; None if there is nobody to judge by.

    Exclusions are the experimenter's doing and count neither way.
    """
    at_risk = flow.stages[_IN_TRIALS : _COMPLETED + 1]
    gone = sum(n for stage in at_risk for how, n in stage.left if how != "excluded")
    over = gone + flow.analysed
    return gone / over if over else None


def _in_order(counts: Counter[str]) -> list[tuple[str, int]]:
    return [(status, counts[status]) for status in LEFT if counts[status]]
