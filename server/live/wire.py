"""Every message of the live socket, both ways, protocol version 1, little endian.

The browser's side is `web/static/js/net/messages.js`; a test holds the two equal. Reading a
message that does not fit raises WireError, which says what was wanted and what came and carries
the close code. This module knows no world: numbers and bytes only.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Literal

PROTOCOL_VERSION = 1
TICK_HZ = 30
SNAPSHOT_HZ = 15
COUNTDOWN_S = 3
MAX_CLIENT_BYTES = 256
NOT_FINITE = (math.inf, -math.inf)
MAX_INPUT_FRAMES = 8
ALL_KEYS = 15
MAX_FIGURES = 8
HIGHEST_FIGURE = 100_000
SILENT_AFTER_S = 0.25

INPUT, SNAPSHOT, PLAN, DISPLAY = 1, 2, 3, 4
INPUT_HEAD = struct.Struct("<BIB")
_INPUT_FRAMES = tuple(struct.Struct("<" + "BH" * n) for n in range(MAX_INPUT_FRAMES + 1))

PhaseName = Literal["waiting", "countdown", "running", "paused", "finished"]
PhaseReason = Literal["start", "resume", "disconnected", "completed", "timed_out"]


class CloseCode(IntEnum):
    """Why the server closes a socket."""

    NORMAL = 1000
    TOO_LARGE = 1009
    RESTARTING = 1012
    TRY_LATER = 1013
    MALFORMED = 4400
    UNKNOWN_TOKEN = 4401
    WRONG_ORIGIN = 4403
    SILENT = 4408
    TAKEN_OVER = 4409
    NO_TRIAL = 4410
    CANNOT_RESUME = 4411


class WireError(Exception):
    """A frame that does not fit: what was wanted, what came, and the close code."""

    def __init__(self, wanted: str, got: str, code: CloseCode = CloseCode.MALFORMED) -> None:
        self.wanted = wanted
        self.got = got
        self.code = code
        super().__init__(f"wanted {wanted}, got {got}")


@dataclass(frozen=True, slots=True)
class Hello:
    """The first frame of a connection."""

    version: int


@dataclass(frozen=True, slots=True)
class Ready:
    """The client has drawn its first frame of the hall, or wants to go on after a pause."""


@dataclass(frozen=True, slots=True)
class Ping:
    """Answered at once with the same number."""

    sent_ms: float


@dataclass(frozen=True, slots=True)
class Attention:
    """Whether the page is shown, has the keyboard, and holds the pointer."""

    visible: bool
    focused: bool
    locked: bool


@dataclass(frozen=True, slots=True)
class Context:
    """The graphics context was lost or restored."""

    lost: bool


@dataclass(frozen=True, slots=True)
class Quality:
    """What the page measured since its last report: frame rates, round trips, long frames."""

    fps: tuple[float, ...]
    rtt_ms: tuple[float, ...]
    long_frames: int
    longest_frame_ms: float

    def __post_init__(self) -> None:
        for figure in (self.long_frames, self.longest_frame_ms):
            if not 0 <= figure <= HIGHEST_FIGURE:
                raise WireError(f"figures from 0 to {HIGHEST_FIGURE}", brief(figure))


@dataclass(frozen=True, slots=True)
class Input:
    """Successive input frames (key bits, yaw in 65536ths of a turn), numbered from `first_seq`."""

    first_seq: int
    frames: tuple[tuple[int, int], ...]


TextMessage = Hello | Ready | Ping | Attention | Context | Quality

_TEXT_TYPES: Mapping[str, tuple[type[TextMessage], Mapping[str, type]]] = {
    "hello": (Hello, {"version": int}),
    "ready": (Ready, {}),
    "ping": (Ping, {"sent_ms": float}),
    "attention": (Attention, {"visible": bool, "focused": bool, "locked": bool}),
    "context": (Context, {"lost": bool}),
    "quality": (
        Quality,
        {"fps": tuple, "rtt_ms": tuple, "long_frames": int, "longest_frame_ms": float},
    ),
}


def parse_text(text: str) -> TextMessage:
    """Read a text message of the client."""
    name, record = read_record(text, MAX_CLIENT_BYTES, _TEXT_TYPES)
    kind, wanted = _TEXT_TYPES[name]
    values = {field: read_field(name, record, field, type_) for field, type_ in wanted.items()}
    return kind(**values)


def read_record(text: str, longest: int, types: Collection[str]) -> tuple[str, Mapping[str, Any]]:
    """The type and the JSON object of a message of at most `longest` characters."""
    if len(text) > longest:
        raise WireError(f"at most {longest} bytes", f"{len(text)} characters", CloseCode.TOO_LARGE)
    try:
        record = json.loads(text)
    except (ValueError, RecursionError):
        raise WireError("a JSON object", "a text that is no JSON") from None
    name = record.get("type") if isinstance(record, dict) else None
    if not isinstance(name, str) or name not in types:
        raise WireError(f"one of the types {', '.join(types)}", brief(name))
    return name, record


def read_field(name: str, record: Mapping[str, Any], field: str, type_: type) -> Any:
    """A field of a message, of just this type; finite numbers only."""
    value = record.get(field)
    if type_ is tuple:
        return _read_figures(name, field, value)
    if type_ is float and type(value) is int and abs(value) < 2**53:
        return float(value)
    if type(value) is type_ and value not in NOT_FINITE and value == value:
        return value
    raise WireError(f"{name}.{field} as {type_.__name__}", brief(value))


def _read_figures(name: str, field: str, value: object) -> tuple[float, ...]:
    """A short list of plain figures from 0 up."""
    figures: list[Any] = value if isinstance(value, list) else [None]
    if len(figures) > MAX_FIGURES or not all(
        type(figure) in (int, float) and 0 <= figure <= HIGHEST_FIGURE for figure in figures
    ):
        wanted = f"up to {MAX_FIGURES} figures from 0 to {HIGHEST_FIGURE}"
        raise WireError(f"{name}.{field} as {wanted}", brief(value))
    return tuple(map(float, figures))


def brief(value: object) -> str:
    """What came, short enough for a sentence."""
    return repr(value)[:60]


def parse_input(data: bytes) -> Input:
    """Read a binary message of the client: u8 1, u32 first_seq, u8 n, n x (u8 keys, u16 yaw)."""
    if len(data) > MAX_CLIENT_BYTES:
        raise WireError(
            f"at most {MAX_CLIENT_BYTES} bytes", f"{len(data)} bytes", CloseCode.TOO_LARGE
        )
    if len(data) < INPUT_HEAD.size or data[0] != INPUT:
        raise WireError("an input message (first byte 1)", f"{len(data)} bytes {data[:6].hex()}")
    _, first_seq, count = INPUT_HEAD.unpack_from(data)
    if not 1 <= count <= MAX_INPUT_FRAMES or len(data) != INPUT_HEAD.size + 3 * count:
        raise WireError(
            f"1 to {MAX_INPUT_FRAMES} frames of 3 bytes",
            f"{count} frames in {len(data) - INPUT_HEAD.size} bytes",
        )
    if first_seq < 1:
        raise WireError("sequence numbers from 1", str(first_seq))
    flat = _INPUT_FRAMES[count].unpack_from(data, INPUT_HEAD.size)
    keys = flat[0::2]
    if max(keys) > ALL_KEYS:
        raise WireError(f"key bits up to {ALL_KEYS}", str(max(keys)))
    return Input(first_seq, tuple(zip(keys, flat[1::2], strict=True)))


def encode_text(record: Mapping[str, Any]) -> str:
    """A JSON text without spare spaces."""
    return json.dumps(record, separators=(",", ":"), allow_nan=False)


def encode_phase(
    phase: PhaseName, tick: int, reason: PhaseReason, acknowledged_seq: int, seconds: float = 0
) -> str:
    """The trial's phase changed; `seconds` until it runs, in a countdown."""
    record: dict[str, Any] = {"type": "phase", "phase": phase, "tick": tick, "reason": reason}
    record["acknowledged_seq"] = acknowledged_seq
    if phase == "countdown":
        record["seconds"] = seconds
    return encode_text(record)


def encode_delivered(boxes: int) -> str:
    """So many boxes are delivered by now."""
    return encode_text({"type": "delivered", "boxes": boxes})


def encode_finished(next_path: str) -> str:
    """The trial is over and stored; the page to open now."""
    return encode_text({"type": "finished", "next": next_path})


def encode_pong(sent_ms: float) -> str:
    """The answer to a ping."""
    return encode_text({"type": "pong", "sent_ms": sent_ms})


def encode_error(message: str) -> str:
    """What went wrong, in a sentence, before a close."""
    return encode_text({"type": "error", "message": message})


def encode_plan(robot: int, corners: Sequence[tuple[int, int]]) -> bytes:
    """A planned path as corner cells (i, j); bays and homes may have j or i one outside."""
    packed = bytearray(struct.pack("<BBH", PLAN, robot, len(corners)))
    for i, j in corners:
        packed += bytes((i + 1, j + 1))
    return bytes(packed)


def encode_display(robots: bytes, stations: bytes, overlays: int) -> bytes:
    """What is visible now: a mask per robot, 0 or 1 per station, the overlays."""
    head = bytes((DISPLAY, overlays, len(robots)))
    return head + robots + bytes((len(stations),)) + stations


def crop_reason(reason: str) -> str:
    """A close reason of at most 123 bytes of UTF-8, as the WebSocket protocol demands."""
    return reason.encode()[:120].decode(errors="ignore")
