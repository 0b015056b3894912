"""Guards the wire: both sides read what the other writes, and refusals say what was wanted."""

import json
import subprocess
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.live import wire
from server.live.audience import Audience
from server.live.snapshots import SnapshotEncoder
from server.live.wire import WireError
from study.ar.elements import Display
from study.warehouse.layout import PRESETS, build_layout
from study.warehouse.world import World

from .stage import SETUP, Listener

ROOT = Path(__file__).parent.parent.parent.parent
READER = """
import * as m from "./web/static/js/net/messages.js";
import { readFileSync } from "node:fs";
const asked = JSON.parse(readFileSync(0, "utf8"));
const hex = (buffer) => Buffer.from(buffer).toString("hex");
const plain = (v) => v instanceof Uint8Array ? [...v] : v;
const read = (h) => m.decodeBinary(new Uint8Array(Buffer.from(h, "hex")).buffer);
process.stdout.write(JSON.stringify({
  binary: asked.binary.map(read),
  texts: asked.texts.map((t) => m.decodeText(t)),
  inputs: asked.inputs.map(([seq, frames]) => hex(m.encodeInput(seq, frames))),
  spoken: [m.encodeHello(), m.encodeReady(), m.encodePing(12.5), m.encodePing(3),
           m.encodeAttention(true, false, true), m.encodeContext(true),
           m.encodeQuality({ fps: [60, 59.5], rtt_ms: [12.5], long_frames: 2,
                             longest_frame_ms: 70 })],
}, (key, value) => plain(value)));
"""


def ask_browser_code(**question: Any) -> dict[str, Any]:
    """Have the client's own module read and write."""
    question = {"binary": [], "texts": [], "inputs": []} | question
    done = subprocess.run(
        ["node", "--input-type=module", "-e", READER],
        input=json.dumps(question),
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stderr
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def study_world(ticks: int = 400) -> World:
    world = World(build_layout(PRESETS["study"]), 9)
    for tick in range(ticks):
        world.step([(1, tick * 150 & 65535)])
    return world


def test_the_browser_reads_snapshots() -> None:
    """Positions to 1/512 m, headings to 1/256 turn, states and boxes exactly."""
    world = study_world()
    data = SnapshotEncoder(world).encode(70_000)
    assert len(data) == 14 + 6 * 12
    (read,) = ask_browser_code(binary=[data.hex()])["binary"]
    assert (read["type"], read["tick"], read["acknowledged"]) == ("snapshot", 400, 70_000 & 65535)
    assert read["human"]["x_m"] == pytest.approx(world.human_x_m, abs=1 / 1024)
    assert read["human"]["y_m"] == pytest.approx(world.human_y_m, abs=1 / 1024)
    assert read["human"]["yaw"] == world.human_yaw
    assert read["blocked"] is world.human_stopped
    for k, robot in enumerate(read["robots"]):
        assert robot["x_m"] == pytest.approx(world.robot_x_m[k], abs=1 / 1024)
        assert robot["y_m"] == pytest.approx(world.robot_y_m[k], abs=1 / 1024)
        turn = (robot["heading"] / 6.283185307179586 * 65536) % 65536
        assert 0 <= int(world.robot_heading[k]) - turn < 256.5
        assert robot["state"] == world.robot_state[k]
        assert robot["carrying"] == world.robot_carrying[k]


def test_the_browser_reads_texts_plans_and_displays() -> None:
    """Everything that a room's audience is sent goes through the client's reader."""
    world = study_world()
    audience = Audience(SETUP, world)
    audience.show(Display(bytes([7, 0, 12] * 4), bytes([1, 0, 1, 0]), 3))
    listener = Listener()
    audience.add(listener, 17)
    texts = [
        *(json.dumps(text) for text in listener.texts),
        wire.encode_phase("countdown", 5, "resume", 17, 3),
        wire.encode_delivered(7),
        wire.encode_finished("/p/abc"),
        wire.encode_pong(1.5),
        wire.encode_error("no"),
    ]
    answer = ask_browser_code(texts=texts, binary=[data.hex() for data in listener.controls])
    assert answer["texts"] == [json.loads(text) for text in texts]
    display, *plans = answer["binary"]
    assert display == {
        "type": "display",
        "overlays": 3,
        "robots": [7, 0, 12] * 4,
        "stations": [1, 0, 1, 0],
    }
    assert [plan["robot"] for plan in plans] == [k for k in range(12) if k % 3 != 1]
    for plan in plans:
        cells = world.planned_path(plan["robot"]).tolist()
        assert walk_corners(plan["corners"]) == cells


def walk_corners(corners: list[list[int]]) -> list[list[int]]:
    """All cells of a path given by its corners."""
    cells = corners[:1]
    for (a, b), (c, d) in pairwise(corners):
        steps = abs(c - a) + abs(d - b)
        assert 0 in (c - a, d - b), "a leg between corners is straight"
        cells += [[a + (c - a) * n // steps, b + (d - b) * n // steps] for n in range(1, steps + 1)]
    return cells


def test_the_server_reads_what_the_browser_writes() -> None:
    frames = [{"keys": k % 16, "yaw": (k * 9973) & 65535} for k in range(8)]
    answer = ask_browser_code(inputs=[[1, frames[:1]], [4_000_000_000, frames]])
    first, second = (wire.parse_input(bytes.fromhex(text)) for text in answer["inputs"])
    assert first == wire.Input(1, ((0, 0),))
    assert second.first_seq == 4_000_000_000
    assert second.frames == tuple((frame["keys"], frame["yaw"]) for frame in frames)
    assert [wire.parse_text(text) for text in answer["spoken"]] == [
        wire.Hello(1),
        wire.Ready(),
        wire.Ping(12.5),
        wire.Ping(3.0),
        wire.Attention(True, False, True),
        wire.Context(True),
        wire.Quality((60.0, 59.5), (12.5,), 2, 70.0),
    ]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "wanted a JSON object, got a text that is no JSON"),
        ("[" * 200, "wanted a JSON object"),
        ("[]", "wanted one of the types hello, ready, ping"),
        ('{"type":"jump"}', "got 'jump'"),
        ('{"type":["hello"]}', "wanted one of the types"),
        ('{"type":"hello"}', "wanted hello.version as int, got None"),
        ('{"type":"hello","version":true}', "wanted hello.version as int, got True"),
        ('{"type":"ping","sent_ms":NaN}', "wanted ping.sent_ms as float, got nan"),
        ('{"type":"ping","sent_ms":1e999}', "got inf"),
        ('{"type":"ping","sent_ms":' + "9" * 150 + "}", "wanted ping.sent_ms as float"),
        ('{"type":"attention","visible":1}', "wanted attention.visible as bool, got 1"),
        ('{"type":"quality","fps":60}', "wanted quality.fps as up to 8 figures from 0 to 100000"),
        ('{"type":"quality","fps":[true]}', "got [True]"),
        ('{"type":"quality","fps":[-1]}', "got [-1]"),
        ('{"type":"quality","fps":[1,1,1,1,1,1,1,1,1]}', "up to 8 figures"),
        (
            '{"type":"quality","fps":[],"rtt_ms":[],"long_frames":-1,"longest_frame_ms":1.0}',
            "figures from 0 to 100000, got -1",
        ),
    ],
)
def test_refused_texts_say_what_was_wanted(text: str, sentence: str) -> None:
    with pytest.raises(WireError) as caught:
        wire.parse_text(text)
    assert sentence in str(caught.value)
    assert caught.value.code == 4400


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b"", "wanted an input message (first byte 1), got 0 bytes"),
        (b"\x02" + bytes(8), "wanted an input message"),
        (b"\x01" + bytes(5), "wanted 1 to 8 frames of 3 bytes, got 0 frames in 0 bytes"),
        (b"\x01\x01\0\0\0\x02" + bytes(3), "got 2 frames in 3 bytes"),
        (b"\x01\x01\0\0\0\x09" + bytes(27), "got 9 frames"),
        (b"\x01\0\0\0\0\x01" + bytes(3), "wanted sequence numbers from 1, got 0"),
        (b"\x01\x01\0\0\0\x01\x10\0\0", "wanted key bits up to 15, got 16"),
    ],
)
def test_refused_input_says_what_was_wanted(data: bytes, sentence: str) -> None:
    with pytest.raises(WireError) as caught:
        wire.parse_input(data)
    assert sentence in str(caught.value)


def test_oversized_messages_have_their_own_code() -> None:
    for parse in (lambda: wire.parse_text(" " * 257), lambda: wire.parse_input(bytes(257))):
        with pytest.raises(WireError) as caught:
            parse()
        assert caught.value.code == 1009


def test_the_longest_report_of_the_browser_fits_its_frame() -> None:
    """Eight figures of each kind, each as long as it can be."""
    code = """
import { QualityWatch } from "./web/static/js/quality.js";
import { encodeQuality } from "./web/static/js/net/messages.js";
const watch = new QualityWatch();
watch.takeReport(0);
for (let n = 0; n < 50; n += 1) { watch.roundTrip(99998.76); watch.frame(n * 98765); }
process.stdout.write(encodeQuality(watch.takeReport(6000)));
"""
    done = subprocess.run(
        ["node", "--input-type=module", "-e", code], capture_output=True, text=True, cwd=ROOT
    )
    message = wire.parse_text(done.stdout)
    assert isinstance(message, wire.Quality), done.stderr
    assert (len(message.fps), len(message.rtt_ms), message.long_frames) == (8, 8, 49)


@given(st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(data: bytes) -> None:
    """No other exception, and what is read is within its limits."""
    try:
        message = wire.parse_input(data)
    except WireError:
        return
    assert 1 <= len(message.frames) <= 8
    assert all(keys < 16 and yaw < 65536 for keys, yaw in message.frames)


@given(st.text(max_size=300) | st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(
        st.sampled_from(["type", "version", "sent_ms", "hello", "ping"]), inner, max_size=3),
).map(json.dumps))  # fmt: skip
def test_any_text_is_read_or_refused(text: str) -> None:
    reason = ""
    try:
        wire.parse_text(text)
    except WireError as problem:
        reason = wire.crop_reason(str(problem))
    assert len(reason.encode()) <= 123


def test_a_plan_without_cells_and_one_in_a_bay() -> None:
    assert wire.encode_plan(3, []) == b"\x03\x03\x00\x00"
    assert wire.encode_plan(0, [(5, -1)]) == b"\x03\x00\x01\x00\x06\x00"
