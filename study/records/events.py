"""The data dictionary of events: every kind a trial can record, with its fields, units and version.

An event belongs to one trial and one tick (1/30 s of simulated time). Kinds that start with
nothing else than what the world did come from the world itself and are reproduced by a replay;
the others tell what the participant's browser or the server did and are stored because nothing
else knows them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from types import MappingProxyType
from typing import Literal

from study.errors import JournalError

Scalar = bool | int | float | str
Source = Literal["world", "display", "room", "client", "expert"]

_TYPES: Mapping[str, tuple[type, ...]] = {
    "bool": (bool,),
    "int": (int,),
    "float": (float, int),
    "str": (str,),
}


@dataclass(frozen=True)
class EventField:
    """One field of an event: its type, unit ("" = none) and meaning."""

    name: str
    type: Literal["bool", "int", "float", "str"]
    unit: str
    meaning: str


@dataclass(frozen=True)
class EventKind:
    """One kind of event. `version` rises whenever its fields or their meaning change."""

    name: str
    source: Source
    meaning: str
    fields: tuple[EventField, ...] = ()
    version: int = 1


@dataclass(frozen=True)
class JournalEvent:
    """Something that happened in a trial.

    `number` counts the trial's events from 0 and never repeats, so a batch that is committed
    twice after a lost answer stores each event once.
    """

    number: int
    tick: int
    kind: str
    at_utc: datetime
    data: Mapping[str, Scalar] = field(default_factory=lambda: MappingProxyType({}))


_ROBOT = EventField("robot", "int", "", "index of the robot, from 0")
_STATION = EventField("station", "int", "", "index of the station, 0 to 3")
_SHELF = EventField("shelf", "int", "", "index of the shelf, rows from below, columns from left")
_BOX = EventField("box", "int", "", "index of the box on its shelf, 0 to 11")
_COLOUR = EventField("colour", "int", "", "0 red, 1 green, 2 blue, 3 yellow")
_SEQ = EventField("seq", "int", "", "number of the last input frame taken over")

_WORLD_KINDS = (
    EventKind("leg_started", "world", "a robot set out for its next shelf", (_ROBOT, _SHELF, _BOX)),
    EventKind(
        "box_picked",
        "world",
        "a robot has loaded a box; its station is chosen",
        (_ROBOT, _COLOUR, _STATION),
    ),
    EventKind("wait_started", "world", "a robot stands in its bay and waits", (_ROBOT, _STATION)),
    EventKind(
        "unload_started", "world", "a person came near and unloading began", (_ROBOT, _STATION)
    ),
    EventKind(
        "box_delivered", "world", "unloading ended and the box counts", (_ROBOT, _COLOUR, _STATION)
    ),
    EventKind("returning_started", "world", "a robot has no task left, drives home", (_ROBOT,)),
    EventKind("home_reached", "world", "a robot is home and stays there", (_ROBOT,)),
    EventKind("trial_completed", "world", "every robot is home"),
    EventKind("trial_timed_out", "world", "the trial reached its cap"),
)

_DISPLAY_KINDS = (
    EventKind(
        "display_decided",
        "display",
        "what the participant sees changed",
        (
            EventField("robots", "str", "", "two hexadecimal digits per robot: its element mask"),
            EventField("stations", "str", "", "one digit per station: 1 = balloon shown"),
            EventField("overlays", "int", "", "1 minimap, 2 off-screen arrows, added up"),
        ),
    ),
    EventKind(
        "policy_replaced",
        "display",
        "from this tick on another policy decides",
        (EventField("policy_sha256", "str", "", "hash of the policy file"),),
    ),
)

_ROOM_KINDS = (
    EventKind(
        "opened",
        "room",
        "the trial was opened, for the first time or again after the server stopped",
        (EventField("resumed", "bool", "", "true when earlier ticks were re-simulated"),),
    ),
    EventKind("countdown_started", "room", "the client is ready; the world starts in 3 s"),
    EventKind("started", "room", "the world runs, from here or again", (_SEQ,)),
    EventKind(
        "paused",
        "room",
        "the world stands still",
        (EventField("reason", "str", "", "disconnected, silent or shutdown"),),
    ),
    EventKind(
        "input_silent",
        "room",
        "no input frame for 250 ms; the human stands still",
    ),
    EventKind(
        "input_resumed",
        "room",
        "input frames arrive again after silence",
        (EventField("silent_s", "float", "s", "how long none had arrived"),),
    ),
    EventKind(
        "input_discarded",
        "room",
        "frames beyond what the elapsed time allows were taken over without effect",
        (EventField("frames", "int", "", "how many"),),
    ),
    EventKind(
        "lagged",
        "room",
        "the server was late and this much world time was not made up",
        (EventField("lost_s", "float", "s", "wall time without ticks"),),
    ),
    EventKind("abandoned", "room", "nobody came back within the study's time limit"),
)

_CLIENT_KINDS = (
    EventKind("connected", "client", "a browser joined the trial"),
    EventKind(
        "disconnected",
        "client",
        "the browser's socket closed",
        (EventField("code", "int", "", "WebSocket close code"),),
    ),
    EventKind("taken_over", "client", "a newer tab of the same participant took the trial over"),
    EventKind(
        "attention",
        "client",
        "the page's visibility, focus or pointer lock changed",
        (
            EventField("visible", "bool", "", "the page is shown"),
            EventField("focused", "bool", "", "the page has the keyboard"),
            EventField("locked", "bool", "", "the pointer is locked to the view"),
        ),
    ),
    EventKind(
        "quality",
        "client",
        "how the picture and the connection were since the last report, every few seconds",
        (
            EventField("fps", "str", "Hz", "frames drawn in each whole second, parted by spaces"),
            EventField("rtt_ms", "str", "ms", "round-trip times measured, parted by spaces"),
            EventField("long_frames", "int", "", "frames that took longer than 50 ms"),
            EventField("longest_frame_ms", "float", "ms", "the longest time between two frames"),
        ),
    ),
    EventKind(
        "context",
        "client",
        "the browser lost or restored its graphics context",
        (EventField("lost", "bool", "", "true = lost, false = restored"),),
    ),
)

_EXPERT = EventField("expert", "str", "", "name of the expert's account")
_PAGE = EventField("client", "str", "", "16 hexadecimal digits that an expert's page gave itself")
_MESSAGE = EventField("seq", "int", "", "number of the page's message, from 1")
_AGENT = EventField("agent", "int", "", "number of the agent: robots from 0, then stations")

_EXPERT_KINDS = (
    EventKind("expert_joined", "expert", "an expert's page joined the run", (_EXPERT, _PAGE)),
    EventKind("expert_left", "expert", "an expert's page is gone", (_EXPERT, _PAGE)),
    EventKind("lead_changed", "expert", "this page's boxes now count", (_EXPERT, _PAGE)),
    EventKind(
        "expert_set",
        "expert",
        "an expert set an agent's boxes",
        (
            *(_EXPERT, _PAGE, _MESSAGE, _AGENT),
            EventField(
                "mask", "int", "", "robots: 1 live location, 2 ghost, 4 trajectory; station: 1"
            ),
        ),
    ),
    EventKind(
        "expert_confirmed",
        "expert",
        "an expert called an agent's boxes right as they are",
        (_EXPERT, _PAGE, _MESSAGE, _AGENT),
    ),
)

EVENT_KINDS: Mapping[str, EventKind] = MappingProxyType(
    {
        kind.name: kind
        for kind in (*_WORLD_KINDS, *_DISPLAY_KINDS, *_ROOM_KINDS, *_CLIENT_KINDS, *_EXPERT_KINDS)
    }
)


def check_event(kind: str, data: Mapping[str, Scalar]) -> None:
    """Raise JournalError unless `data` has exactly the fields of `kind`, each of its type."""
    entry = EVENT_KINDS.get(kind)
    if entry is None:
        raise JournalError(
            f"there is no event “{kind}” in the data dictionary",
            next_step="Describe it in study/records/events.py before recording it.",
        )
    wanted = {field.name: field for field in entry.fields}
    if set(wanted) != set(data):
        raise JournalError(
            f"the event “{kind}” has the fields {sorted(data)}, wanted {sorted(wanted)}",
            next_step="Record exactly the fields of the data dictionary.",
        )
    for name, value in data.items():
        if type(value) not in _TYPES[wanted[name].type]:
            raise JournalError(
                f"the field “{name}” of the event “{kind}” is {value!r},"
                f" wanted {wanted[name].type}",
                next_step="Record the type of the data dictionary.",
            )
