"""A participant's page as a program reads it: where its form goes and how to fill it in.

Answers are drawn by seed. What a page does not tell (the bounds of a number) is learned as people
learn it: from the sentence with which the form comes back.
"""

from __future__ import annotations

import random
import re
from dataclasses import dataclass, field
from html.parser import HTMLParser

FIRST_GUESS = 30
DEVICE = {
    "keyboard": "yes",
    "mouse": "yes",
    "webgl": "yes",
    "touch_only": "no",
    "frame_rate_hz": "60.0",
    "latency_ms": "1.0",
}
_BOUNDS = re.compile(r"from (-?\d+) to (-?\d+)(?: in steps of (\d+))?")
_REMARKS = ("", "The robots were easy to follow.", "=1+1", "Nothing to add; “thank you”, René.")


@dataclass
class Field:
    """One field of a form: the values offered, or free text."""

    name: str
    kind: str
    values: list[str] = field(default_factory=list)
    bounds: tuple[int, int, int] | None = None


class PageReader(HTMLParser):
    """What matters of a page. `action` is empty where nothing is to be sent."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.action = ""
        self.fields: dict[str, Field] = {}
        self.live = ""
        self.share_done: float | None = None
        self.has_code = False
        self._slider: tuple[int, int, int] | None = None
        self._problem = ""
        self.problems: dict[str, str] = {}
        self.feed(page)

    @property
    def step(self) -> str:
        """The step that the form belongs to."""
        return self.action.rsplit("/", 1)[-1]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note forms, fields and what the page says of itself."""
        given = {name: value or "" for name, value in attrs}
        if tag == "body":
            self.live = given.get("data-live", "")
        elif tag == "form" and given.get("method") == "post":
            self.action = given.get("action", "")
        elif tag == "progress":
            self.share_done = float(given["value"]) / float(given["max"])
        elif tag == "div" and "data-slider" in given:
            low, high, step = (int(given[f"data-{key}"]) for key in ("lowest", "highest", "step"))
            self._slider = (low, high, step)
        elif given.get("id") == "completion-code":
            self.has_code = True
        elif given.get("id", "").endswith("-problem"):
            self._problem = given["id"].removesuffix("-problem")
        elif tag in ("input", "textarea") and given.get("name"):
            self._add_field(tag, given)

    def handle_data(self, data: str) -> None:
        """The sentence of a problem."""
        if self._problem and data.strip():
            self.problems[self._problem] = data.strip()
            self._problem = ""

    def _add_field(self, tag: str, given: dict[str, str]) -> None:
        name = given["name"]
        kind = "textarea" if tag == "textarea" else given.get("type", "text")
        one = self.fields.setdefault(name, Field(name, kind))
        if kind in ("radio", "checkbox", "hidden"):
            one.values.append(given.get("value", ""))
        if kind == "text" and self._slider is not None:
            one.bounds, self._slider = self._slider, None


def fill_in(page: PageReader, draws: random.Random) -> dict[str, str]:
    """Answers to every field of a page, drawn anew at each call."""
    form: dict[str, str] = {}
    for one in page.fields.values():
        if one.kind == "radio":
            form[one.name] = draws.choice(one.values)
        elif one.kind == "checkbox":
            if not one.name.endswith("_declined"):
                form[one.name] = one.values[0]
        elif one.kind == "textarea":
            form[one.name] = draws.choice(_REMARKS)
        elif one.kind == "hidden":
            form[one.name] = DEVICE.get(one.name, one.values[0])
        else:
            form[one.name] = _number(one.bounds, draws)
    return form


def mend(form: dict[str, str], page: PageReader, draws: random.Random) -> dict[str, str]:
    """The form again, with answers that fit the sentences of the page that brought it back."""
    mended = dict(form)
    for name, sentence in page.problems.items():
        found = _BOUNDS.search(sentence)
        if found is not None:
            low, high, step = (int(part or 1) for part in found.groups())
            mended[name] = _number((low, high, step), draws)
        elif name in page.fields and page.fields[name].kind == "textarea":
            mended[name] = "A word, since one is asked for."
    return mended


def _number(bounds: tuple[int, int, int] | None, draws: random.Random) -> str:
    if bounds is None:
        return str(FIRST_GUESS)
    low, high, step = bounds
    return str(low + step * draws.randrange((high - low) // step + 1))
