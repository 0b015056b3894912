"""The expert's checkboxes: one mask of elements per agent, robots first, then stations."""

from __future__ import annotations

from collections.abc import Sequence

NEVER = -1


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
