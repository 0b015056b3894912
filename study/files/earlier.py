"""Studies as earlier versions of the software stored them, read by today's record.

A stored version never changes: it keeps the hash that it was stored by.
"""

from __future__ import annotations

import json
from typing import Any

from study.config import Study

_PANEL = ("PROLIFIC_PID", "STUDY_ID", "SESSION_ID")
_PAGES = (
    "welcome", "consent", "browser_check", "instructions", "debrief", "screened_out", "withdrawn",
    "timed_out", "excluded",
)  # fmt: skip


def read_stored(text: str, config_hash: str) -> Study:
    """The study in a stored version's JSON, of any format."""
    document = json.loads(text)
    if "format" in document:
        return Study.model_validate_json(text).stored_as(config_hash)
    return Study.model_validate(_from_first_format(document)).stored_as(config_hash)


def _from_first_format(document: dict[str, Any]) -> dict[str, Any]:
    """Format 1 had one instrument after each trial, texts in sections, codes without redirects."""
    entries = dict(document)
    entries["questionnaire"] = [entries["questionnaire"]]
    entries["panel"] = {"parameters": entries.pop("panel_fields", _PANEL)}
    entries["display"] = {"ribbon_widest_at": entries.pop("ribbon_widest_at", "goal")}
    idle_s = max(10.0, entries.pop("abandon_after_s", 3600.0))
    entries["limits"] = {
        "abandon_after_s": idle_s,
        "idle_after_s": idle_s,
        "on_disconnect": entries.pop("on_disconnect", "pause"),
        "time_scale": entries.pop("time_scale_limit", 4.0),
    }
    codes = entries.pop("completion_codes")
    entries["endings"] = {outcome: {"code": code} for outcome, code in codes.items()}
    texts = entries["texts"]
    entries["texts"] = texts | {name: _page(texts[name]) for name in _PAGES if name in texts}
    return entries


def _page(page: dict[str, Any]) -> dict[str, Any]:
    """A page whose sections became Markdown."""
    parts = []
    for section in page.get("sections", ()):
        if section.get("heading"):
            parts.append(f"## {section['heading']}")
        parts += section.get("paragraphs", ())
        if section.get("points"):
            parts.append("\n".join(f"* {point}" for point in section["points"]))
    return {"title": page["title"], "lead": page.get("lead", ""), "body": "\n\n".join(parts)}
