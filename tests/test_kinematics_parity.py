"""The browser's human and the server's move by the same rule, equal to the last bit."""

from __future__ import annotations

import json
import math
import random
import shutil
import struct
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from study.warehouse.kinematics import step_human, trig_table, wanted_step
from study.warehouse.layout import PRESETS, Layout, build_layout, solids_near_cells

MODULE = Path(__file__).parent.parent / "web" / "static" / "js" / "input" / "kinematics.js"

PROGRAM = """
import { stepHuman, trigTable } from %s;
import { readFileSync } from "node:fs";
const halls = JSON.parse(readFileSync(0, "utf8"));
const bits = (v) => Buffer.from(new Float64Array([v]).buffer).toString("hex");
const cosines = trigTable();
const out = { table: [...cosines].map(bits), walks: [] };
for (const { solids, stepM, robots, start, frames } of halls) {
  let place = start;
  const walk = [];
  for (const [keys, yaw] of frames) {
    const step = stepHuman({ x: place[0], y: place[1] }, keys, yaw, stepM, cosines, solids, robots);
    place = [step.x, step.y];
    walk.push([bits(step.x), bits(step.y), step.contact]);
  }
  out.walks.push(walk);
}
console.log(JSON.stringify(out));
"""


def bits(value: float) -> str:
    """The eight bytes of a float64, little endian."""
    return struct.pack("<d", value).hex()


def make_walk(layout: Layout, rng: random.Random, length: int) -> dict[str, Any]:
    """A random walk among random robots, with long runs into walls, racks and robots."""
    free = [(i, j) for j, i in np.argwhere(layout.free).tolist()]
    start = layout.cell_center_m(*rng.choice(free))
    places = [layout.cell_center_m(*cell) for cell in rng.sample(free, min(60, len(free) // 3))]
    robots = [p for p in places if math.dist(p, start) >= 0.52]
    frames = []
    while len(frames) < length:
        frames += [[rng.randrange(16), rng.randrange(65536)]] * rng.randrange(1, 60)
    return {
        "solids": layout.solids_m.tolist(),
        "stepM": layout.spec.human_speed_mps / 30,
        "robots": robots,
        "start": start,
        "frames": frames[:length],
    }


def walk_here(layout: Layout, walk: dict[str, Any]) -> list[list[Any]]:
    """The same walk by the server's rule, with its short lists of near solids."""
    near = solids_near_cells(layout)
    robots = np.array(walk["robots"], dtype=np.float64).reshape(-1, 2)
    x, y = walk["start"]
    steps = []
    for keys, yaw in walk["frames"]:
        cell = layout.cell_index(math.floor(x / 0.6), math.floor((y - 0.6) / 0.6))
        wanted = wanted_step(keys, yaw, walk["stepM"], trig_table())
        x, y, contact = step_human((x, y), wanted, layout.solids_m, near[cell], robots)
        steps.append([bits(x), bits(y), contact])
    return steps


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_both_sides_walk_alike() -> None:
    """Guards prediction: a rule that differs by one bit would drift and jerk the view."""
    rng = random.Random(20)
    layouts = [build_layout(spec) for spec in PRESETS.values() for _ in range(4)]
    walks = [make_walk(layout, rng, 600) for layout in layouts]
    program = PROGRAM % json.dumps(MODULE.resolve().as_uri())
    words = ["node", "--input-type=module", "-e", program]
    done = subprocess.run(words, input=json.dumps(walks), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    there = json.loads(done.stdout)
    assert there["table"] == [bits(value) for value in trig_table().tolist()]
    contacts = 0
    for layout, walk, steps in zip(layouts, walks, there["walks"], strict=True):
        here = walk_here(layout, walk)
        for n, (a, b) in enumerate(zip(here, steps, strict=True)):
            assert a == b, (layout.spec.name, n, walk["frames"][n])
        contacts += sum(step[2] for step in here)
    assert contacts > 100, "the walks hardly met a robot"


def test_nobody_walks_through_anything() -> None:
    """Guards the short lists of near solids: bodies stay apart on long walks in every hall."""
    rng = random.Random(4)
    for spec in PRESETS.values():
        layout = build_layout(spec)
        walk = make_walk(layout, rng, 1500)
        for x_bits, y_bits, _ in walk_here(layout, walk):
            x, y = (struct.unpack("<d", bytes.fromhex(word))[0] for word in (x_bits, y_bits))
            for x0, y0, x1, y1 in walk["solids"]:
                gap = math.hypot(max(x0 - x, 0, x - x1), max(y0 - y, 0, y - y1))
                assert gap >= 0.3 - 1e-9
            assert all(math.dist((x, y), robot) >= 0.5 for robot in walk["robots"])


def test_sliding_along_a_wall_keeps_the_speed_along_it() -> None:
    """Guards the feel: walking at 45 degrees into a wall slides with cos 45 of the speed."""
    layout = build_layout(PRESETS["practice"])
    near = solids_near_cells(layout)
    x, y = 0.31, 3.0
    for _ in range(30):
        cell = layout.cell_index(math.floor(x / 0.6), math.floor((y - 0.6) / 0.6))
        wanted = wanted_step(1, 24576, 1.4 / 30, trig_table())
        x, y, _ = step_human((x, y), wanted, layout.solids_m, near[cell], np.zeros((0, 2)))
    assert x == pytest.approx(0.3, abs=1e-3)
    assert y - 3.0 == pytest.approx(1.4 * math.sqrt(0.5), rel=0.01)
