"""The expert's checkboxes: one mask of elements per agent, robots first, then stations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from study.errors import JournalError

NEVER = -1
_KEPT = ("masks", "proposals", "edited", "confirmed")


class Checkboxes:
    """What the expert wants to be visible, and when each agent's boxes were touched.

    All are ticked at the start of a run and carry over between its trials. `masks`, `proposals`:
    elements by agent. `edited`, `confirmed`: tick of the run of the last change by the expert, and
    of the last time the expert said that an agent is right as it is; NEVER before the first.
    """

    def __init__(self, robots: int, stations: int, *, follow: bool) -> None:
        self.robots = robots
        self.follow = follow
        self.full = (7,) * robots + (1,) * stations
        self.masks = list(self.full)
        self.proposals = list(self.full)
        self.edited = [NEVER] * len(self.full)
        self.confirmed = [NEVER] * len(self.full)

    def propose(self, proposals: Sequence[int]) -> None:
        """Take the policy's proposals; a box that follows takes those that changed."""
        if self.follow:
            for agent, (old, new) in enumerate(zip(self.proposals, proposals, strict=True)):
                changed = old ^ new
                self.masks[agent] = self.masks[agent] & ~changed | new & changed
        self.proposals = list(proposals)

    def set(self, agent: int, mask: int, tick: int) -> None:
        """The expert sets an agent's boxes; leaving them as they are confirms them."""
        mask &= self.full[agent]
        if mask != self.masks[agent]:
            self.masks[agent] = mask
            self.edited[agent] = tick
        else:
            self.confirmed[agent] = tick

    def edit_age(self, agent: int, tick: int) -> int:
        """Ticks since the expert last changed this agent's boxes; NEVER if that never happened."""
        return NEVER if self.edited[agent] == NEVER else tick - self.edited[agent]

    def was_edited(self, agent: int, tick: int, within: int) -> bool:
        """Whether the expert changed this agent's boxes in the last `within` ticks."""
        return self.edited[agent] != NEVER and tick - self.edited[agent] <= within

    def was_confirmed(self, agent: int, tick: int, within: int) -> bool:
        """Whether the expert changed them, or called them right, in the last `within` ticks."""
        known = self.confirmed[agent] != NEVER and tick - self.confirmed[agent] <= within
        return known or self.was_edited(agent, tick, within)

    def copy(self) -> Checkboxes:
        """The same boxes for somebody else to go on with."""
        other = Checkboxes(self.robots, len(self.full) - self.robots, follow=self.follow)
        other.load(self.to_json())
        return other

    def to_json(self) -> dict[str, list[int]]:
        """All that carries over from one trial to the next."""
        return {name: list(getattr(self, name)) for name in _KEPT}

    def load(self, record: Mapping[str, Any]) -> None:
        """Take over what `to_json` gave. Errors: JournalError if it is of other agents."""
        for name in _KEPT:
            values = [int(value) for value in record.get(name, ())]
            if len(values) != len(self.full):
                raise JournalError(
                    f"{len(values)} entries, wanted one for each of {len(self.full)} agents",
                    where=f"boxes.{name}",
                    next_step="Restore this learning run from a backup.",
                )
            setattr(self, name, values)
