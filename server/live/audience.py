"""Those who see a trial: its participant and any read-only watchers, and what they are sent."""

from __future__ import annotations

import zlib
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from server.live import wire
from server.live.sink import Sink
from server.live.snapshots import SnapshotEncoder
from study.ar.elements import PATH_ELEMENTS, Display
from study.warehouse.halls import CELL_M, EYE_HEIGHT_M, HUMAN_RADIUS_M, ROBOT_RADIUS_M

if TYPE_CHECKING:
    from server.live.ports import TrialSetup
    from study.warehouse.layout import Layout
    from study.warehouse.world import World

SHELF_LEVELS = 3
UNSENT = -1


class Audience:
    """Sends one world to everyone who looks at it; nobody slow can hold anybody up.

    Planned paths go out only for robots of which an element that needs the path is on, when they
    changed or came into view.
    """

    def __init__(self, setup: TrialSetup, world: World) -> None:
        self._setup = setup
        self._world = world
        self._encoder = SnapshotEncoder(world)
        self._sinks: list[Sink] = []
        self._display = Display.nothing(len(world.robot_x_m), len(world.layout.stations))
        self._sent_plans = [UNSENT] * len(world.robot_x_m)
        self._seen_plans: list[int] = []

    @property
    def sinks(self) -> tuple[Sink, ...]:
        """Everyone, the participant included."""
        return tuple(self._sinks)

    def add(self, sink: Sink, acknowledged_seq: int) -> None:
        """A newcomer gets the welcome, the display and the plans; the phase is the room's word."""
        sink.send_text(wire.encode_text(self._welcome(acknowledged_seq)))
        self._send_display(sink)
        for robot, version in enumerate(self._sent_plans):
            if version != UNSENT:
                sink.send_control(self._encode_plan(robot))
        sink.send_snapshot(self._encoder.encode(acknowledged_seq))
        self._sinks.append(sink)

    def remove(self, sink: Sink) -> None:
        """Forget a sink; unknown ones are ignored."""
        if sink in self._sinks:
            self._sinks.remove(sink)

    def tell(self, text: str) -> None:
        """Send a text message to all."""
        for sink in self._sinks:
            sink.send_text(text)

    def show(self, display: Display) -> None:
        """What is visible changed."""
        self._display = display
        self._seen_plans = []
        for robot, mask in enumerate(display.robots):
            if not mask & PATH_ELEMENTS:
                self._sent_plans[robot] = UNSENT
        for sink in self._sinks:
            self._send_display(sink)
        self._send_plans()

    def send_snapshot(self, acknowledged_seq: int) -> None:
        """Send what changed since the last call, and where everything is now."""
        self._send_plans()
        if self._sinks:
            data = self._encoder.encode(acknowledged_seq)
            for sink in self._sinks:
                sink.send_snapshot(data)

    def _send_plans(self) -> None:
        versions = self._world.plan_version.tolist()
        if versions == self._seen_plans:
            return
        self._seen_plans = versions
        for robot, version in enumerate(versions):
            visible = self._display.robots[robot] & PATH_ELEMENTS
            if visible and version != self._sent_plans[robot]:
                self._sent_plans[robot] = version
                data = self._encode_plan(robot)
                for sink in self._sinks:
                    sink.send_control(data)

    def _send_display(self, sink: Sink) -> None:
        shown = self._display
        sink.send_control(wire.encode_display(shown.robots, shown.stations, shown.overlays))

    def _encode_plan(self, robot: int) -> bytes:
        return wire.encode_plan(robot, self._world.planned_corners(robot).tolist())

    def _welcome(self, acknowledged_seq: int) -> dict[str, Any]:
        setup, world = self._setup, self._world
        of_run = {} if setup.number is None else {"trial": setup.number}
        return {
            **of_run,
            "type": "welcome",
            "version": wire.PROTOCOL_VERSION,
            "trial_id": setup.trial_id,
            "label": setup.label,
            "kind": setup.kind,
            "tick_hz": wire.TICK_HZ,
            "snapshot_hz": wire.SNAPSHOT_HZ,
            "time_scale": setup.time_scale,
            "tick": world.tick,
            "cap_s": setup.spec.cap_s,
            "acknowledged_seq": acknowledged_seq,
            "boxes_total": setup.spec.boxes_total,
            "boxes_delivered": int(world.boxes_delivered),
            "human": {
                "x_m": float(world.human_x_m),
                "y_m": float(world.human_y_m),
                "yaw": int(world.human_yaw),
            },
            "hall": {
                "scale": setup.scale,
                **describe_hall(world.layout),
                "box_seed": zlib.crc32(str(setup.seed).encode()),
            },
            "robots": len(world.robot_x_m),
            "settings": {"ribbon_widest_at": setup.ribbon_widest_at},
        }


@lru_cache(maxsize=32)
def describe_hall(layout: Layout) -> dict[str, Any]:
    """The hall as the browser needs it: the same for every trial in it."""
    spec = layout.spec
    return {
        "width_cells": layout.width_cells,
        "height_cells": layout.height_cells,
        "hall_width_m": layout.hall_width_m,
        "hall_height_m": layout.hall_height_m,
        "cell_m": CELL_M,
        "shelves_m": layout.shelves_m.tolist(),
        "shelf_levels": SHELF_LEVELS,
        "stations": [
            {
                "index": station.index,
                "center_m": [float(v) for v in station.center_m],
                "bays": [[int(v) for v in cell] for cell in station.bay_cells],
            }
            for station in layout.stations
        ],
        "homes": [[int(v) for v in cell] for cell in layout.homes],
        "solids_m": layout.solids_m.tolist(),
        "human_speed_mps": spec.human_speed_mps,
        "human_radius_m": HUMAN_RADIUS_M,
        "robot_radius_m": ROBOT_RADIUS_M,
        "eye_height_m": EYE_HEIGHT_M,
    }
