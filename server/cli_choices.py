"""Halls, simulated people and modes as choices on the command line."""

from __future__ import annotations

from enum import StrEnum


class Scale(StrEnum):
    """The halls by name."""

    PRACTICE = "practice"
    SMALL = "small"
    STUDY = "study"
    LARGE = "large"
    LAB = "lab"


class Worker(StrEnum):
    """Simulated workers."""

    CYCLIC = "cyclic"
    WANDERER = "wanderer"
    BLOCKER = "blocker"
    BELIEVER = "believer"


class Expert(StrEnum):
    """Simulated experts."""

    TABLE = "table"


class BackendName(StrEnum):
    """Where headless trials run."""

    LOKY = "loky"
    DASK = "dask"


class Mode(StrEnum):
    """Whose data."""

    LIVE = "live"
    PILOT = "pilot"
    BOT = "bot"
