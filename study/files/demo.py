"""The demo study: the file that `varil init` starts from, read like any other.

It recruits pilots: a demonstration must never end up among live data.
"""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from importlib import resources
from typing import Any

from study.config import Study

FILE = "demo.toml"


@functools.cache
def demo_text() -> str:
    """The demo study's file, comments included."""
    return resources.files("study.files").joinpath(FILE).read_text(encoding="utf-8")


@functools.cache
def demo_entries() -> Mapping[str, Any]:
    """Its entries; not to be changed."""
    return tomllib.loads(demo_text())


@functools.cache
def paper_study() -> Study:
    """The demo study `demo`: the paper's three conditions and questionnaire in our wording."""
    return Study.model_validate(demo_entries())
