"""The browser check: which devices can take part, and what is kept of the measurement.

Keyboard, mouse and WebGL are needed; frame rate and latency are recorded, never a reason to refuse.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from study.errors import AnswerError

FLAGS = ("keyboard", "mouse", "webgl", "touch_only")
FIGURES = ("frame_rate_hz", "latency_ms")
FIELDS = (*FLAGS, *FIGURES)
_YES = frozenset({"yes", "true", "1"})
_NO = frozenset({"no", "false", "0"})


def judge_device(form: Mapping[str, str]) -> dict[str, str]:
    """Stored values by field if the device will do; raises `AnswerError` naming what is missing."""
    flags = {name: _read_flag(form.get(name, "")) for name in FLAGS}
    if flags["webgl"] is None:
        raise AnswerError(
            {
                "webgl": "The check did not run. Please allow JavaScript for this page, or use "
                "another browser, then load the page again."
            }
        )
    problems = {}
    if flags["touch_only"]:
        problems["touch_only"] = (
            "This device seems to have only a touch screen. Please open the same address on a "
            "computer with a keyboard and a mouse; you can go on from here."
        )
    if not flags["webgl"]:
        problems["webgl"] = (
            "This browser cannot draw the 3D warehouse (WebGL 2 is missing or switched off). "
            "Please open the same address in another browser or on another computer."
        )
    if not flags["keyboard"] and not problems:
        problems["keyboard"] = "Please press one of the keys named in the list, then go on."
    if not flags["mouse"] and not problems:
        problems["mouse"] = "Please move the mouse over this page, then go on."
    if problems:
        raise AnswerError(problems)
    answers = {name: "yes" if flags[name] else "no" for name in FLAGS}
    return answers | {name: _read_figure(form.get(name, "")) for name in FIGURES}


def _read_flag(raw: str) -> bool | None:
    text = raw.strip().lower()
    return True if text in _YES else False if text in _NO else None


def _read_figure(raw: str) -> str:
    """A non-negative finite figure with one decimal, or empty if it could not be measured."""
    try:
        figure = float(raw[:40])
    except ValueError:
        return ""
    return f"{figure:.1f}" if math.isfinite(figure) and 0 <= figure < 1e6 else ""
