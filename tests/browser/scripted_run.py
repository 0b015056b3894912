"""What a scripted learning run would tell the expert's page: a recorded world, boxes, curves.

Who proposes what is scripted; the trial's inputs are recorded once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from server.live import wire
from server.live.audience import describe_hall
from server.live.snapshots import SnapshotEncoder
from study.headless import simulate_trial
from study.learning.settings import LearningSettings
from study.warehouse.layout import PRESETS, build_layout
from study.warehouse.world import World

RUN_ID = "4f1c0a7be2d94c5f8a6b3d2e1f009c77"
SEED = 5
SNAPSHOT_TICKS = 120
DRIVING = (0, 2, 5)
WAITING = 3


@dataclass
class Knobs:
    """What a test can turn."""

    hold: bool = False
    refuse: str = ""
    away: bool = False
    phase: str = "running"
    lead: str = "first"
    others: list[dict[str, str]] = field(default_factory=list)
    agreement: list[dict[str, Any]] = field(default_factory=list)
    iteration: int = 87
    status: str = "open"


class ScriptedRun:
    """One world, one set of boxes, and every message about them."""

    def __init__(self, scale: str) -> None:
        self.scale = scale
        self.layout = build_layout(PRESETS[scale])
        trial = simulate_trial(self.layout, SEED, "cyclic", keep_inputs=True)
        assert trial.inputs is not None
        self.inputs = trial.inputs
        self.settings = LearningSettings(seed=SEED)
        self.knobs = Knobs()
        self.clients: list[str] = []
        self.taken: dict[str, int] = {}
        self.boxes = [7] * len(self.layout.homes) + [1] * len(self.layout.stations)
        self.pairs = self.knobs.iteration * 25
        self.trial = 2
        self.begin()

    def begin(self) -> None:
        """Begin the trial anew."""
        self.world = World(self.layout, SEED)
        self.encoder = SnapshotEncoder(self.world)
        self.sent_plans = [-1] * len(self.layout.homes)
        for _ in range(900):
            self.step()

    def step(self) -> None:
        """One tick with the recorded input."""
        keys, yaw = self.inputs[min(self.world.tick, len(self.inputs) - 1)]
        self.world.step([(int(keys), int(yaw))])

    @property
    def drawn(self) -> list[int]:
        """Which elements could draw anything, by agent."""
        states = self.world.robot_state.tolist()
        busy = {
            int(s) for s, x in zip(self.world.robot_station, states, strict=True) if x == WAITING
        }
        robots = [7 if state in DRIVING else 1 for state in states]
        return [*robots, *(int(n in busy) for n in range(len(self.layout.stations)))]

    @property
    def proposals(self) -> list[int]:
        """A scripted policy: near robots in full, waiting ones live, balloons where one waits."""
        world = self.world
        masks = []
        for robot, state in enumerate(world.robot_state.tolist()):
            far_m = math.dist(
                (world.human_x_m, world.human_y_m),
                (world.robot_x_m[robot], world.robot_y_m[robot]),
            )
            masks.append(5 if state == 2 else 1 if state == WAITING or far_m < 6 else 0)
        return [*masks, *self.drawn[len(masks) :]]

    @property
    def by_expert(self) -> list[int]:
        """Every third agent shows the policy's choice."""
        return [int(agent % 3 != 2) for agent in range(len(self.boxes))]

    @property
    def shown(self) -> list[int]:
        """What is displayed, by agent."""
        pairs = zip(self.boxes, self.proposals, self.by_expert, strict=True)
        return [box if own else proposal for box, proposal, own in pairs]

    def display(self) -> bytes:
        """The display message."""
        robots = len(self.layout.homes)
        return wire.encode_display(bytes(self.shown[:robots]), bytes(self.shown[robots:]), 0)

    def agents(self) -> str:
        """The agents message, as the newest page gets it."""
        return wire.encode_text(
            {
                "type": "agents", "trial": self.trial, "tick": self.world.tick,
                "boxes": self.boxes, "proposals": self.proposals, "drawn": self.drawn,
                "by_expert": self.by_expert, "recording": self.lead() is not None,
                "taken_seq": self.taken.get(self.clients[-1], 0) if self.clients else 0,
            }
        )  # fmt: skip

    def lead(self) -> str | None:
        """Client of the lead."""
        if self.knobs.lead == "first":
            return next(iter(self.clients), None)
        return self.knobs.lead or None

    def experts(self) -> str:
        """The experts message."""
        present = [{"name": "anna", "client": client} for client in self.clients]
        return wire.encode_text(
            {"type": "experts", "lead": self.lead(), "present": [*present, *self.knobs.others]}
        )

    def progress(self) -> str:
        """The progress message."""
        tick = self.world.tick
        return wire.encode_text(
            {
                "type": "progress", "trial": self.trial, "tick": tick, "pairs": self.pairs,
                "units": self.pairs, "iteration": self.pairs // 25, "iterations": 240,
                "beta": self.settings.beta_of(min(239, self.pairs // 25)),
                "policy_sha256": "0" * 64,
                "next_snapshot_tick": (tick // SNAPSHOT_TICKS + 1) * SNAPSHOT_TICKS,
            }
        )  # fmt: skip

    def curve(self) -> str:
        """A curve as it might have come about."""
        n = range(self.pairs // 25)
        wave = [math.sin(j * 12.9898) * 43758.5453 % 1 for j in n]
        off = [round(6 * math.exp(-j / 40) + 6 * wave[j] + 1) for j in n]
        on = [round(3 * math.exp(-((j - 30) ** 2) / 900) + 4 * wave[-1 - j]) for j in n]
        flat = [round(17 + 4 * wave[j]) for j in n]
        return wire.encode_text(
            {
                "type": "curve", "from": 0,
                "lines": {
                    "policy": {
                        "disable": off, "enable": on, "off_rate": [v / 48 for v in off],
                        "hamming_rate": [(a + b) / 48 for a, b in zip(off, on, strict=True)],
                        "shown_share": [0.4 + 0.1 * w for w in wave],
                    },
                    "arroch": {
                        "disable": flat, "enable": [2] * len(flat),
                        "off_rate": [v / 48 for v in flat],
                        "hamming_rate": [(v + 2) / 48 for v in flat],
                        "shown_share": [0.93] * len(flat),
                    },
                    "all_off": {
                        "disable": [0] * len(flat), "enable": [20 - v // 2 for v in off],
                        "off_rate": [0.0] * len(flat),
                        "hamming_rate": [(20 - v // 2) / 48 for v in off],
                        "shown_share": [0.0] * len(flat),
                    },
                },
            }
        )  # fmt: skip

    def agreement(self) -> str:
        """The agreement message."""
        return wire.encode_text({"type": "agreement", "experts": self.knobs.agreement})

    def ended(self) -> str:
        """The ended message."""
        return wire.encode_text({"type": "ended", "status": self.knobs.status})

    def phase(self) -> str:
        """The phase message."""
        return wire.encode_text(
            {"type": "phase", "phase": self.knobs.phase, "tick": self.world.tick, "reason": "start"}
        )

    def run(self, client: str) -> str:
        """The run message."""
        return wire.encode_text(
            {
                "type": "run", "run_id": RUN_ID, "version": 1, "robots": len(self.layout.homes),
                "stations": len(self.layout.stations), "settings": self.settings.to_json(),
                "worker": "person", "you": {"name": "anna", "client": client},
                "pairs_per_iteration": 25, "snapshot_ticks": SNAPSHOT_TICKS,
                "taken_seq": self.taken.get(client, 0),
            }
        )  # fmt: skip

    def welcome(self) -> str:
        """The welcome message."""
        world = self.world
        return wire.encode_text(
            {
                "type": "welcome", "version": 1, "trial_id": f"trial-{self.trial}",
                "trial": self.trial, "label": "Learning", "kind": "trial", "tick_hz": 30,
                "snapshot_hz": 15, "time_scale": 1, "tick": world.tick, "cap_s": 1500,
                "acknowledged_seq": 0, "boxes_total": self.layout.spec.boxes_total,
                "boxes_delivered": int(world.boxes_delivered),
                "human": {"x_m": world.human_x_m, "y_m": world.human_y_m, "yaw": world.human_yaw},
                "hall": {"scale": self.scale, **describe_hall(self.layout), "box_seed": 5},
                "robots": len(self.layout.homes), "settings": {"ribbon_widest_at": "goal"},
            }
        )  # fmt: skip

    def plans(self, changed_only: bool) -> list[bytes]:
        """The planned paths, all or those that changed."""
        found = []
        for robot, version in enumerate(self.world.plan_version.tolist()):
            if not changed_only or self.sent_plans[robot] != version:
                corners = self.world.planned_corners(robot).tolist()
                found.append(wire.encode_plan(robot, corners))
            if changed_only:
                self.sent_plans[robot] = version
        return found
