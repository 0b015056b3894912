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
"""The statuses of those who left, in the order in which a stage names them."""
_REACHED = {"consent": 0, "browser-check": 1, "demographics": 2, "instructions": 2, "practice": 2}
_IN_TRIALS, _PLAYED, _COMPLETED = 3, 4, 5


@dataclass(frozen=True)
class Crowd:
    """So many participants of one mode who stand alike.

    `before`: the status before an exclusion; `step`: where they are or were when they left.
    """

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
    """One box of the flow: who reached it, who is there now, and who left from there and how.

    Who reached a stage is present, left from it, or reached the next one; at the last stage, the
    rest is what counts in the analysis.
    """

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


@dataclass(frozen=True)
class DropOut:
    """So many left before the end, of so many who can be judged."""

    gone: int
    judged: int

    @property
    def share(self) -> float | None:
        """The share that left; None if there is nobody to judge by."""
        return self.gone / self.judged if self.judged else None


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


def count_drop_out(flow: ParticipantFlow) -> DropOut:
    """Who left between the practice and the end, of those past the practice and not under way.

    Exclusions are the experimenter's doing and count neither way; who withdrew after completing
    has reached the end.
    """
    gone = sum(_left_by_themselves(stage) for stage in flow.stages[_IN_TRIALS:_COMPLETED])
    finished = flow.analysed + _left_by_themselves(flow.stages[_COMPLETED])
    return DropOut(gone, gone + finished)


def _left_by_themselves(stage: Stage) -> int:
    return sum(number for how, number in stage.left if how != "excluded")


def _in_order(counts: Counter[str]) -> list[tuple[str, int]]:
    return [(status, counts[status]) for status in LEFT if counts[status]]
