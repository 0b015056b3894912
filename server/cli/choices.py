"""Halls, simulated people and modes as choices on the command line."""

from __future__ import annotations

from enum import StrEnum

NO_BALLOONS = "only the believer looks at balloons"


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
    ORACLE = "oracle"


class Expert(StrEnum):
    """Simulated experts."""

    PERSON = "person"
    TABLE = "table"


class Wish(StrEnum):
    """What the expert `person` wants to be visible."""

    DECLUTTER = "declutter"
    INFORM = "inform"


class View(StrEnum):
    """The picture at which the expert `person` looks."""

    WORKER = "worker"
    ABOVE = "above"


class BalloonBelief(StrEnum):
    """Which balloons count for the believer."""

    ONSET = "onset"
    ALWAYS = "always"


class Control(StrEnum):
    """Policies that nobody learned."""

    ALL_OFF = "all_off"
    NO_GHOST = "no_ghost"


class BackendName(StrEnum):
    """Where headless trials run."""

    LOKY = "loky"
    DASK = "dask"


class Mode(StrEnum):
    """Whose data."""

    LIVE = "live"
    PILOT = "pilot"
    BOT = "bot"
