"""What an expert's page says, version 1: JSON texts, the first of them a hello.

The browser's side is `web/static/js/net/expert_messages.js`. Reading a message that does not fit
raises WireError. Whether an agent or a trial exists is the run's to say, not the wire's.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from server.live.wire import Ping, WireError, brief, encode_text, read_field, read_record

EXPERT_VERSION = 1
MAX_EXPERT_BYTES = 4096
MAX_CHANGES = 256
LARGEST = 2**53

_PAGE = re.compile(r"[0-9a-f]{16}")


@dataclass(frozen=True, slots=True)
class Hello:
    """The first message. `client`: what the page calls itself; `last_seq`: its last number."""

    version: int
    client: str
    last_seq: int


@dataclass(frozen=True, slots=True)
class Edit:
    """One gesture on the boxes, made while the page showed this tick of this trial.

    `changes`: (agent, bits to switch on, bits to switch off).
    """

    seq: int
    trial: int
    tick: int
    changes: tuple[tuple[int, int, int], ...]


@dataclass(frozen=True, slots=True)
class Confirm:
    """“These agents are right as they are.”"""

    seq: int
    trial: int
    tick: int
    agents: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class TakeLead:
    """Asks for the lead that nobody has."""


@dataclass(frozen=True, slots=True)
class HandOver:
    """Gives the lead to another page."""

    to: str


ExpertMessage = Hello | Edit | Confirm | TakeLead | HandOver | Ping
TYPES = ("hello", "edit", "confirm", "take_lead", "hand_over", "ping")


def parse_message(text: str) -> ExpertMessage:
    """Read a message of an expert's page."""
    name, record = read_record(text, MAX_EXPERT_BYTES, TYPES)
    if name == "hello":
        version = read_field(name, record, "version", int)
        return Hello(version, _page(name, record, "client"), _count(name, record, "last_seq", 0))
    if name == "edit":
        changes = tuple(_change(entry) for entry in _entries(name, record, "changes"))
        return Edit(*_moment(name, record), changes)
    if name == "confirm":
        agents = tuple(_whole(name, entry) for entry in _entries(name, record, "agents"))
        return Confirm(*_moment(name, record), agents)
    if name == "hand_over":
        return HandOver(_page(name, record, "to"))
    if name == "ping":
        return Ping(read_field(name, record, "sent_ms", float))
    return TakeLead()


def encode_stored(seq: int) -> str:
    """Everything of this page up to this number is stored for good."""
    return encode_text({"type": "stored", "seq": seq})


def encode_refused(seq: int, message: str) -> str:
    """Nothing of this message was applied; the sentence says why."""
    return encode_text({"type": "refused", "seq": seq, "message": message})


def encode_ended(status: str) -> str:
    """The run is over: `finished` or `stopped`."""
    return encode_text({"type": "ended", "status": status})


def _moment(name: str, record: Mapping[str, Any]) -> tuple[int, int, int]:
    seq = _count(name, record, "seq", 1)
    return seq, _count(name, record, "trial", 0), _count(name, record, "tick", 0)


def _count(name: str, record: Mapping[str, Any], field: str, least: int) -> int:
    value: int = read_field(name, record, field, int)
    if not least <= value <= LARGEST:
        raise WireError(f"{name}.{field} from {least}", brief(value))
    return value


def _page(name: str, record: Mapping[str, Any], field: str) -> str:
    value: str = read_field(name, record, field, str)
    if not _PAGE.fullmatch(value):
        raise WireError(f"{name}.{field} as 16 hexadecimal digits", brief(value))
    return value


def _entries(name: str, record: Mapping[str, Any], field: str) -> list[Any]:
    value: list[Any] = read_field(name, record, field, list)
    if not 1 <= len(value) <= MAX_CHANGES:
        raise WireError(f"{name}.{field} with 1 to {MAX_CHANGES} entries", f"{len(value)}")
    return value


def _change(entry: object) -> tuple[int, int, int]:
    if not isinstance(entry, list) or len(entry) != 3:
        raise WireError("edit.changes as [agent, on, off]", brief(entry))
    agent, on, off = (_whole("edit", value) for value in entry)
    return agent, on, off


def _whole(name: str, value: object) -> int:
    if type(value) is not int or not 0 <= value <= LARGEST:
        raise WireError(f"{name} with whole numbers from 0", brief(value))
    return value
