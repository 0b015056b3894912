"""The expert `person`: looks at a picture, picks one agent, thinks, points and clicks, one by one.

It judges from what can be seen, see `watching` and `wishes`; it never learns the agents' discrete
states. It looks once a second. Whoever differs from its wish may be picked next, urgent ones more
likely. The first box costs reaction, thought, pointing and a click, each further one of the row a
short way and a click. Boxes of elements that would draw nothing now are greyed on its page and left
alone. A click may hit the same box of a neighbouring row; a robot's status may be misjudged.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from study.ar.display_kernels import new_shown, show
from study.ar.drawn import drawn_elements
from study.ar.elements import Display
from study.learning.boxes import Checkboxes
from study.people.beliefs import WAITS, new_memory
from study.people.habits import Habits
from study.people.looking import VIEW
from study.people.watching import SEEN, SPOT, count_crowds, watch
from study.people.wishes import NO_WISH, Impression, Wish, misjudge, wish_robot, wish_station
from study.warehouse.halls import TICK_HZ
from study.warehouse.kernels import compiled_entry
from study.warehouse.tasks import Draws
from study.warehouse.world import World

STOPPED_M = 0.1
Click = tuple[int, int, int, bool]
"""Tick of the trial, agent, element, whether it is to be on; element 0: the row is right."""


class Person:
    """One person over a whole run. `confirms`: says so when an agent is right as it is."""

    def __init__(self, seed: int, habits: Habits, *, confirms: bool = False) -> None:
        self.habits = habits
        self.values = habits.values_of("expert")
        self.confirms = confirms
        self._draws = Draws(seed)
        self._picture: _Picture | None = None
        self._clicks: list[Click] = []

    def act(self, world: World, display: Display, boxes: Checkboxes, tick: int) -> None:
        """Click what is due, look when it is time, and turn to the next agent when free."""
        if self._picture is None or self._picture.world is not world:
            self._picture = _Picture(world, self._draws.next() >> 2, self.habits)
            self._clicks = []
        now = world.tick
        acted = False
        while self._clicks and self._clicks[0][0] <= now:
            self._click(self._clicks.pop(0), boxes, tick)
            acted = True
        looked = now % self._picture.look_ticks == 0
        if looked:
            self._picture.look(display)
        if (looked or acted) and not self._clicks:
            self._turn_to_next(self._picture, boxes, now)

    def answer(self, boxes: Checkboxes, states: Sequence[int]) -> None:
        """Nothing: a person does not know the agents' states."""

    def _turn_to_next(self, picture: _Picture, boxes: Checkboxes, now: int) -> None:
        """Pick an agent whose boxes differ from the wish, and plan the clicks."""
        drawn = drawn_elements(picture.world)[: boxes.robots] + [1] * len(picture.spots)
        wishes = picture.wishes(self.habits.wish, self.values)
        wrong = [
            agent
            for agent, wish in enumerate(wishes)
            if (wish.on ^ boxes.masks[agent]) & wish.about & drawn[agent]
        ]
        if not wrong:
            if self.confirms:
                self._confirm_oldest(wishes, boxes, now)
            return
        weight = self.values["urgent_weight"]
        agent = self._pick(wrong, [weight if wishes[a].urgent else 1.0 for a in wrong])
        wish = wishes[agent]
        if agent < boxes.robots and self._chance() < self.values["misjudge"]:
            wish = picture.mistake(agent, self.habits.wish, self.values)
        differing = (wish.on ^ boxes.masks[agent]) & wish.about & drawn[agent]
        self._plan(agent, [bit for bit in (1, 2, 4) if differing & bit], wish.on, now)

    def _plan(self, agent: int, bits: list[int], on: int, now: int) -> None:
        """Plan clicks on an agent's boxes; where nothing is to be clicked, the time of judging."""
        v = self.values
        at_s = now / TICK_HZ + v["react_s"] + v["decide_s"]
        if bits or self.confirms:
            at_s += v["point_s"] + v["click_s"]
        for bit in bits or [0]:
            self._clicks.append((int(np.ceil(at_s * TICK_HZ)), agent, bit, bool(on & bit)))
            at_s += v["next_box_s"] + v["click_s"]

    def _confirm_oldest(self, wishes: Sequence[Wish], boxes: Checkboxes, now: int) -> None:
        known = [agent for agent, wish in enumerate(wishes) if wish is not NO_WISH]
        if known:
            oldest = min(known, key=lambda agent: max(boxes.confirmed[agent], boxes.edited[agent]))
            self._plan(oldest, [], 0, now)

    def _click(self, click: Click, boxes: Checkboxes, tick: int) -> None:
        _, agent, bit, on = click
        if bit == 0:
            if self.confirms:
                boxes.set(agent, boxes.masks[agent], tick)
            return
        if bool(boxes.masks[agent] & bit) == on:
            return
        if self._chance() < self.values["wrong_box"]:
            agent = self._neighbour(agent, boxes.robots, len(boxes.masks))
        boxes.set(agent, boxes.masks[agent] ^ bit, tick)

    def _neighbour(self, agent: int, robots: int, agents: int) -> int:
        """Return the row above or below among the same kind of agents; itself if there is none."""
        low, high = (0, robots) if agent < robots else (robots, agents)
        rows = [row for row in (agent - 1, agent + 1) if low <= row < high]
        return self._pick(rows, [1.0] * len(rows)) if rows else agent

    def _pick(self, agents: list[int], weights: list[float]) -> int:
        left = self._chance() * sum(weights)
        for agent, weight in zip(agents, weights, strict=True):
            left -= weight
            if left < 0:
                return agent
        return agents[-1]

    def _chance(self) -> float:
        return self._draws.next() / 2.0**64


class _Picture:
    """What the person looks at during one trial, and what it remembers of it."""

    def __init__(self, world: World, seed: int, habits: Habits) -> None:
        eyes = habits.values_of("worker")
        robots, stations = world.layout.spec.robots, len(world.layout.stations)
        self.world = world
        self.look_ticks = int(eyes["walking_look_s"] * TICK_HZ)
        self.crowd = habits.values_of("expert")["crowd_robots"]
        self.crowd_m = habits.values_of("expert")["crowd_m"]
        self.memory = new_memory(world.layout, seed, eyes)
        self.memory.beliefs["noticed"] = 0
        self.shown = new_shown(world.layout, "none", None)
        self.seen = np.zeros(robots, dtype=SEEN)
        self.spots = np.zeros(stations, dtype=SPOT)
        self.eyes = np.zeros(1, dtype=VIEW)
        self.eyes["through"] = habits.view == "above"
        self._place = (world.human_x_m, world.human_y_m)
        seen = (self.eyes, self.seen, self.spots)
        self._own = (world.floor, world.motion, self.memory, self.shown, *seen)
        self._counted = (world.motion, self.memory, self.seen, self.crowd_m)
        self._watch = compiled_entry(watch, *self._own, 0)
        self._count = compiled_entry(count_crowds, *self._counted)
        self._impressions: list[Impression] = []

    def look(self, display: Display) -> None:
        """Take in the picture once; a worker who has hardly moved since the last time looks all
        around."""
        x, y = self.world.human_x_m, self.world.human_y_m
        stopped = abs(x - self._place[0]) + abs(y - self._place[1]) < STOPPED_M
        self._place = (x, y)
        show(self.shown, display)
        self._watch(*self._own, int(stopped))
        self._count(*self._counted)
        now = self.world.tick
        rows = zip(
            self.seen.tolist(), self.memory.beliefs[["kind", "noticed"]].tolist(), strict=True
        )
        self._impressions = [
            Impression(
                kind=kind,
                known=bool(known),
                direct=bool(direct),
                placed=bool(placed),
                crowded=crowd >= self.crowd,
                longest=bool(longest),
                away_m=away_m,
                left_s=left_s,
                unseen_s=(now - noticed) / TICK_HZ,
            )
            for (known, direct, placed, crowd, longest, _, away_m, left_s), (kind, noticed) in rows
        ]

    def wishes(self, rule: str, values: dict[str, float]) -> list[Wish]:
        """What is wanted of each agent after the last look, robots first, then stations."""
        first = self.memory.beliefs["first"].tolist()
        waited_at = {
            first[k]
            for k, one in enumerate(self._impressions)
            if one.kind == WAITS and one.unseen_s <= values["probe_s"]
        }
        return [wish_robot(rule, one, values) for one in self._impressions] + [
            wish_station(bool(known), station in waited_at, away_m < values["near_m"])
            for station, (known, away_m) in enumerate(self.spots.tolist())
        ]

    def mistake(self, robot: int, rule: str, values: dict[str, float]) -> Wish:
        """What is wanted of a robot whose status is misjudged."""
        one = self._impressions[robot]
        return wish_robot(rule, one._replace(kind=misjudge(one.kind), left_s=0.0), values)
