"""One table from what can go wrong to what the outside world is told.

Status for pages and JSON, close code for sockets. The first entry that fits counts, so the more
special ones stand first.
"""

from __future__ import annotations

from dataclasses import dataclass

from server.store.engine import DatabaseInUse, StorageAway
from server.store.schema import SchemaMismatch
from study.errors import (
    AnswerError,
    InvalidValue,
    JournalError,
    NotAllowedLive,
    NotFound,
    PolicyError,
    StudyError,
    UnknownToken,
    WrongMoment,
    WrongStep,
)
from study.protocol.panel import PanelIdRefused, TookPartAlready


class Refused(StudyError):
    """The request is not one that this person or page may make."""


class ForeignOrigin(Refused):
    """The request was started by a page of another site."""

    def __init__(self) -> None:
        super().__init__(
            "this form was sent from another site, so it was not accepted",
            next_step="Open the page here and send the form again.",
        )


class SignInNeeded(Refused):
    """Only staff may open this, and nobody is signed in."""

    def __init__(self) -> None:
        super().__init__("this page is for staff", next_step="Please sign in first.")


class RoleNeeded(Refused):
    """Somebody is signed in, but the role does not cover this."""

    def __init__(self, needed: str) -> None:
        self.needed = needed
        super().__init__(
            f"this page needs the role “{needed}”",
            next_step="Sign in with an account that has it, or ask an administrator.",
        )


class TooLarge(StudyError):
    """The request's body is larger than any form here can be."""

    def __init__(self, limit_bytes: int) -> None:
        self.limit_bytes = limit_bytes
        super().__init__(
            f"what was sent is larger than the {limit_bytes // 1024} kB allowed here",
            next_step="Shorten the text, or choose a smaller file, and send the form again; go "
            "back to find what you typed.",
        )


class TooOften(StudyError):
    """Too many attempts in a short time."""

    def __init__(self, wait_s: int) -> None:
        self.wait_s = wait_s
        super().__init__(
            "there were too many attempts to sign in",
            next_step=f"Please wait {wait_s} seconds, then try again.",
        )


@dataclass(frozen=True)
class Problem:
    """What the outside is told: HTTP status, headline of the page, close code of a socket."""

    status: int
    headline: str
    close_code: int


_TABLE: tuple[tuple[type[StudyError], Problem], ...] = (
    (UnknownToken, Problem(404, "This link is not known here", 4401)),
    (NotFound, Problem(404, "There is nothing at this address", 4401)),
    (AnswerError, Problem(422, "Some answers need your attention", 4400)),
    (PanelIdRefused, Problem(400, "Please come through your recruitment panel", 4400)),
    (TookPartAlready, Problem(409, "You have taken part already", 4410)),
    (NotAllowedLive, Problem(409, "This cannot be opened right now", 1013)),
    (WrongStep, Problem(409, "You are at another step", 4410)),
    (WrongMoment, Problem(409, "This does not fit what is going on", 1013)),
    (ForeignOrigin, Problem(403, "Not accepted from another site", 4403)),
    (SignInNeeded, Problem(401, "Please sign in", 4403)),
    (RoleNeeded, Problem(403, "Your account may not open this", 4403)),
    (TooLarge, Problem(413, "Too much was sent at once", 1009)),
    (TooOften, Problem(429, "Too many attempts", 1013)),
    (StorageAway, Problem(503, "Our storage does not answer", 1013)),
    (SchemaMismatch, Problem(503, "The server is being updated", 1013)),
    (DatabaseInUse, Problem(503, "The server is being updated", 1013)),
    (JournalError, Problem(500, "This round cannot go on", 4411)),
    (PolicyError, Problem(500, "This round cannot go on", 4411)),
    (InvalidValue, Problem(400, "The server could not read this request", 4400)),
    (Refused, Problem(403, "This is not allowed", 4403)),
    (StudyError, Problem(500, "Something went wrong on our side", 1013)),
)


def problem_of(error: StudyError) -> Problem:
    """What to tell the outside about this error."""
    return next(problem for kind, problem in _TABLE if isinstance(error, kind))
