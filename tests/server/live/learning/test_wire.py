"""Guards what an expert's page may say: read, or refused with a sentence and a code."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from server.live.learning import wire
from server.live.wire import Ping, WireError

ROOT = Path(__file__).parents[4]
PAGE = "0123456789abcdef"
EDIT: dict[str, Any] = {
    "type": "edit", "seq": 3, "trial": 0, "tick": 90, "changes": [[0, 1, 6], [12, 0, 1]],
}  # fmt: skip
SAID_BY_THE_BROWSER = """
import * as m from "./web/static/js/net/expert_messages.js";
const when = { trial: 2, tick: 60 };
console.log(JSON.stringify([m.encodeExpertHello("%s", 4), m.encodeEdit(5, when, [[1, 0, 7]]),
  m.encodeConfirm(6, when, [3, 4]), m.encodeTakeLead(), m.encodeHandOver("%s")]));
"""


def read(record: Any) -> wire.ExpertMessage:
    return wire.parse_message(json.dumps(record))


def test_the_browser_s_messages_are_read() -> None:
    """The module that the page uses, run by node."""
    program = SAID_BY_THE_BROWSER % (PAGE, PAGE)
    words = ["node", "--input-type=module", "-e", program]
    done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert [wire.parse_message(text) for text in json.loads(done.stdout)] == [
        wire.Hello(1, PAGE, 4),
        wire.Edit(5, 2, 60, ((1, 0, 7),)),
        wire.Confirm(6, 2, 60, (3, 4)),
        wire.TakeLead(),
        wire.HandOver(PAGE),
    ]
    assert read({"type": "ping", "sent_ms": 5}) == Ping(5.0)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"seq": 0}, "wanted edit.seq from 1, got 0"),
        ({"seq": 2**60}, "wanted edit.seq from 1"),
        ({"seq": True}, "wanted edit.seq as int, got True"),
        ({"tick": -1}, "wanted edit.tick from 0"),
        ({"trial": 1.5}, "wanted edit.trial as int"),
        ({"changes": []}, "wanted edit.changes with 1 to 256 entries, got 0"),
        ({"changes": [[0, 1]]}, "wanted edit.changes as [agent, on, off], got [0, 1]"),
        ({"changes": [[0, 1, -1]]}, "wanted edit with whole numbers from 0, got -1"),
        ({"changes": [[0, 1, True]]}, "wanted edit with whole numbers from 0, got True"),
        ({"changes": "all"}, "wanted edit.changes as list"),
        ({"type": "confirm", "agents": [1.0]}, "wanted confirm with whole numbers"),
        ({"type": "hand_over", "to": "0123"}, "wanted hand_over.to as 16 hexadecimal digits"),
        ({"type": "hand_over", "to": PAGE.upper()}, "wanted hand_over.to as 16 hexadecimal"),
        ({"type": "hello", "version": 1, "client": PAGE, "last_seq": -1}, "wanted hello.last_seq"),
        ({"type": "sudo"}, "wanted one of the types hello, edit"),
    ],
)
def test_refused_messages_say_what_was_wanted(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(WireError) as caught:
        read(EDIT | changes)
    assert sentence in str(caught.value)


def test_a_message_that_is_too_long_has_its_own_code() -> None:
    with pytest.raises(WireError) as caught:
        wire.parse_message(" " * (wire.MAX_EXPERT_BYTES + 1))
    assert caught.value.code == 1009


json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)
fields = st.sampled_from(["seq", "trial", "tick", "changes", "agents", "client", "to", "sent_ms"])


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from(wire.TYPES), st.dictionaries(fields, json_values, max_size=5))
def test_any_message_is_read_or_refused(kind: str, record: dict[str, Any]) -> None:
    """No other exception, and what is read is within its limits."""
    try:
        message = wire.parse_message(json.dumps(EDIT | record | {"type": kind}))
    except WireError:
        return
    if isinstance(message, wire.Edit):
        assert 1 <= message.seq <= 2**53
        assert all(min(change) >= 0 and len(change) == 3 for change in message.changes)
