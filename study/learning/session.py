"""One trial of a learning run with people: PolicyUp, the display, and the experts' boxes.

Within a tick: the world's step, then `update` (a policy that has come is installed, the agents
look, pairs are taken, the display is decided), then what experts said, in order. Everything that
enters is an entry (kind, data) of the journal, so settings, the state at the trial's start, the
world's seed, inputs and entries give every bit again: `apply` is the one way in, live and replayed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from study.ar.display import DECISION_EVERY_TICKS, DisplayClock
from study.ar.drawn import drawn_elements
from study.ar.elements import Display
from study.ar.situation import ObservedWorld
from study.errors import InvalidValue, JournalError, WrongMoment
from study.learning.agreement import Setting
from study.learning.boxes import Checkboxes
from study.learning.dataset import Dataset, Pair
from study.learning.panel import Panel
from study.learning.policy_up import PolicyUp, Version
from study.learning.settings import LearningSettings
from study.learning.training import TrainingOrder
from study.warehouse.state import RobotState

Scalar = bool | int | float | str
Data = Mapping[str, Scalar]
Entry = tuple[str, Data]
Change = tuple[int, int, int]


class LearningSession:
    """What a room needs of a display (`display`, `start`, `update`), and what experts may do.

    `up` is the run, `panel` its experts. The boxes of the page that leads are the run's; each
    other expert has boxes of their own, which are compared and never displayed.
    """

    def __init__(self, up: PolicyUp, panel: Panel) -> None:
        self.up = up
        self.panel = panel
        self.tick = 0
        self._clock = DisplayClock(up, up.robots, up.agents - up.robots)
        self._own: dict[str, Checkboxes] = {}
        self._offered: dict[int, tuple[Version, str]] = {}
        self._taken_pairs = len(up.dataset)
        self._settings: list[Setting] = []
        self._entries: list[Entry] = []
        up.is_recording = panel.is_led

    @property
    def display(self) -> Display:
        """What is visible now."""
        return self._clock.display

    # ---- time -------------------------------------------------------------------------------

    def start(self, world: ObservedWorld) -> Display:
        """The first decision, before the first tick."""
        self._attend(world)
        return self._clock.start(world)

    def update(self, world: ObservedWorld) -> Display | None:
        """After each step; the new display if this tick brings a decision that changes it."""
        self.tick = world.tick
        if world.tick % DECISION_EVERY_TICKS:
            return None
        self._attend(world)
        return self._clock.update(world)

    def offer(self, version: Version, policy_sha256: str) -> None:
        """A training is done: its policy decides from the next decision on, in order."""
        self._offered[version.iterations] = (version, policy_sha256)

    def _attend(self, world: ObservedWorld) -> None:
        while self.up.versions[-1].iterations + 1 in self._offered:
            version, policy_sha256 = self._offered.pop(self.up.versions[-1].iterations + 1)
            self.up.install(version)
            self._entries.append(("policy_replaced", {"policy_sha256": policy_sha256}))
        is_due = self.up.is_snapshot_due(world.tick)
        self.up.attend(world, self.display)
        for boxes in self._own.values():
            boxes.propose(self.up.boxes.proposals)
        if is_due:
            self._compare(world)

    def _compare(self, world: ObservedWorld) -> None:
        """Note what each other expert had set at this snapshot; a robot at home is left out."""
        lead, drawn = self.panel.lead_name, drawn_elements(world)
        at_home = (world.robot_state == RobotState.HOME).tolist()
        for expert in dict.fromkeys(self.panel.present.values()):
            if expert == lead:
                continue
            masks = self._own[expert].masks
            self._settings += (
                Setting(self.up.trial, world.tick, expert, agent, mask, lead_mask, seen)
                for agent, (mask, lead_mask, seen) in enumerate(
                    zip(masks, self.up.boxes.masks, drawn, strict=True)
                )
                if agent >= self.up.robots or not at_home[agent]
            )

    # ---- what experts do: each gives the entries to be recorded, already applied ---------------

    def join(self, expert: str, page: str) -> tuple[Entry, ...]:
        """An expert's page is there; the first of a run leads, and who leads and loads the page
        again leads on. Errors: WrongMoment.
        """
        if self.panel.is_known_as_another(page, expert):
            raise WrongMoment(
                "this page belongs to another account", next_step="Load the page again."
            )
        entries = self._record(("expert_joined", _name(expert, page)))
        leads = self.panel.lead is None or self.panel.lead_name == expert
        return entries + self.take_lead(page) if leads and not self.panel.is_led else entries

    def leave(self, page: str) -> tuple[Entry, ...]:
        """An expert's page is gone; nothing if it was not there."""
        expert = self.panel.present.get(page)
        return () if expert is None else self._record(("expert_left", _name(expert, page)))

    def take_lead(self, page: str) -> tuple[Entry, ...]:
        """A page takes the lead that nobody connected has. Errors: WrongMoment."""
        self.panel.check_taking(page)
        return () if self.panel.lead == page else self._lead(page)

    def hand_over(self, page: str, to: str) -> tuple[Entry, ...]:
        """The page that leads hands the lead to another. Errors: WrongMoment."""
        self.panel.check_handing(page, to)
        return () if page == to else self._lead(to)

    def edit(self, page: str, seq: int, changes: Sequence[Change]) -> tuple[Entry, ...]:
        """One gesture: bits to switch on and off by agent; all of it or, with an error, nothing.

        A message that was taken already gives no entry. Errors: InvalidValue.
        """
        if seq <= self.panel.taken_seq(page):
            return ()
        boxes = self.boxes_of(page)
        masks: dict[int, int] = {}
        for agent, on, off in changes:
            self._check_agent(agent)
            if on & off or (on | off) & ~boxes.full[agent] or min(on, off) < 0:
                raise InvalidValue(
                    f"agent {agent} has no boxes {on} to switch on and {off} to switch off"
                )
            masks[agent] = masks.get(agent, boxes.masks[agent]) & ~off | on
        message = self._message(page, seq)
        return self._record(
            *(
                ("expert_set", {**message, "agent": agent, "mask": mask})
                for agent, mask in masks.items()
            )
        )

    def confirm(self, page: str, seq: int, agents: Sequence[int]) -> tuple[Entry, ...]:
        """“These are right as they are.” Taken already: no entry. Errors: InvalidValue."""
        if seq <= self.panel.taken_seq(page):
            return ()
        for agent in agents:
            self._check_agent(agent)
        message = self._message(page, seq)
        return self._record(
            *(("expert_confirmed", {**message, "agent": agent}) for agent in dict.fromkeys(agents))
        )

    def check_moment(self, trial: int, tick: int) -> None:
        """Whether a page may speak of this trial and tick. Errors: WrongMoment."""
        if trial != self.up.trial:
            raise WrongMoment(f"trial {trial + 1} is not the present one, so nothing was changed")
        if not 0 <= tick <= self.tick:
            raise WrongMoment(f"tick {tick} has not come yet, so nothing was changed")

    def boxes_of(self, page: str) -> Checkboxes:
        """The boxes that a page sets: the run's if it leads, else its expert's own."""
        expert = self.panel.name_of(page)
        return self.up.boxes if page == self.panel.lead else self._own[expert]

    def apply(self, kind: str, data: Data) -> None:
        """Let an expert's entry happen now. Errors: JournalError for one that cannot be."""
        expert, page = str(data["expert"]), str(data["client"])
        if kind == "expert_joined":
            self.panel.add(expert, page)
            if page != self.panel.lead and expert not in self._own:
                self._own[expert] = self._fresh_boxes()
        elif kind == "expert_left":
            self.panel.remove(page)
        elif kind == "lead_changed":
            self._change_lead(page)
        elif kind in ("expert_set", "expert_confirmed"):
            self._set(kind, page, data)
        else:
            raise JournalError(f"“{kind}” is nothing an expert does", where=f"tick {self.tick}")
        self.up.is_recording = self.panel.is_led

    def _record(self, *entries: Entry) -> tuple[Entry, ...]:
        for kind, data in entries:
            self.apply(kind, data)
        return entries

    def _message(self, page: str, seq: int) -> dict[str, Scalar]:
        return {**_name(self.panel.name_of(page), page), "seq": seq}

    def _lead(self, page: str) -> tuple[Entry, ...]:
        return self._record(("lead_changed", _name(self.panel.name_of(page), page)))

    def _change_lead(self, page: str) -> None:
        """Who led goes on with a copy of the run's boxes; the run's stay as they are."""
        former = self.panel.lead_name
        self.panel.give_lead(page)
        if former is not None:
            self._own[former] = self.up.boxes.copy()

    def _set(self, kind: str, page: str, data: Data) -> None:
        agent = int(data["agent"])
        self._check_agent(agent)
        boxes = self.boxes_of(page)
        mask = int(data["mask"]) if kind == "expert_set" else boxes.masks[agent]
        boxes.set(agent, mask, self.up.run_tick(self.tick))
        self.panel.take(page, int(data["seq"]))

    def _check_agent(self, agent: int) -> None:
        if not 0 <= agent < self.up.agents:
            raise InvalidValue(
                f"there is no agent {agent}", next_step=f"Agents are 0 to {self.up.agents - 1}."
            )

    def _fresh_boxes(self) -> Checkboxes:
        """Boxes of somebody who has set nothing yet."""
        stations = self.up.agents - self.up.robots
        boxes = Checkboxes(self.up.robots, stations, follow=self.up.boxes.follow)
        boxes.propose(self.up.boxes.proposals)
        return boxes

    # ---- what came of it, each once ------------------------------------------------------------

    def take_pairs(self) -> list[tuple[int, Pair]]:
        """New pairs with their numbers in the run."""
        first, self._taken_pairs = self._taken_pairs, len(self.up.dataset)
        return list(enumerate(self.up.dataset.pairs[first:], first))

    def take_settings(self) -> list[Setting]:
        """What the other experts had set at new snapshots."""
        taken, self._settings = self._settings, []
        return taken

    def take_entries(self) -> list[Entry]:
        """What is to be recorded besides what experts did: policies that were replaced."""
        taken, self._entries = self._entries, []
        return taken

    def owed_orders(self) -> tuple[TrainingOrder, ...]:
        """Trainings whose policy has neither come nor been offered, oldest first."""
        return tuple(o for o in self.up.orders if o.iteration not in self._offered)

    # ---- between trials ---------------------------------------------------------------------

    def to_json(self) -> dict[str, Any]:
        """The run's state right after `PolicyUp.begin_trial`, besides D and the versions."""
        own = {expert: boxes.to_json() for expert, boxes in sorted(self._own.items())}
        return {"up": self.up.to_json(), "panel": self.panel.to_json(), "own": own}

    @classmethod
    def from_json(
        cls,
        record: Mapping[str, Any],
        settings: LearningSettings,
        agents: tuple[int, int],
        dataset: Dataset,
        versions: list[Version],
    ) -> LearningSession:
        """The trial at its start. `agents`: robots, stations. Errors: JournalError."""
        up = PolicyUp(settings, *agents, train=None)
        up.load(record["up"], dataset, versions)
        session = cls(up, Panel.from_json(record["panel"]))
        for expert, boxes in record["own"].items():
            session._own[expert] = session._fresh_boxes()
            session._own[expert].load(boxes)
        return session


def begin_session(settings: LearningSettings, agents: tuple[int, int]) -> LearningSession:
    """A new run before its first trial. `agents`: robots, stations."""
    return LearningSession(PolicyUp(settings, *agents, train=None), Panel())


def _name(expert: str, page: str) -> dict[str, str]:
    return {"expert": expert, "client": page}
