"""Finding an instrument of the library by name. A file has the same keys as a study file."""

from __future__ import annotations

import copy
import functools
import tomllib
from importlib import resources
from typing import Any

NAMES = ("consent", "demographics", "paper-q1-q6", "nasa-tlx", "sus", "comments")
"""The instruments that `use` may name; `<name>.toml` beside this module."""


@functools.cache
def _read(name: str) -> dict[str, Any]:
    file = resources.files("study.protocol.instruments").joinpath(f"{name}.toml")
    return tomllib.loads(file.read_text(encoding="utf-8"))


def find_instrument(name: str) -> dict[str, Any]:
    """The entries of an instrument named in `NAMES`."""
    return copy.deepcopy(_read(name))
