"""Where participants come from, what they are told at the end, and where they may be sent.

A panel is whatever recruits participants: it appends its own parameters to the join link and
expects a code, or a visit to its own address, at the end. An address is followed only if it is
https and its host is named in the study.
"""

from __future__ import annotations

import re
import string
from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from study.errors import InvalidValue, WrongMoment
from study.protocol.records import Problem, Record, find_twins, refuse

LONGEST_ID = 200
_UNFILLED = re.compile(r"\{\{.*\}\}|\$\{.*\}")
PROLIFIC = ("PROLIFIC_PID", "STUDY_ID", "SESSION_ID")
RESERVED = ("join",)
_ADDRESS = re.compile(r"https://(?P<host>[A-Za-z0-9.-]+)(?P<rest>[/?#][\x21-\x7e]*)?")
_BLANK = re.compile(r"\{(\w+)\}")
_PLAIN = frozenset(string.ascii_letters + string.digits + "-._~")

ParameterName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,39}$")]
HostName = Annotated[
    str, Field(pattern=r"^([a-z0-9]([a-z0-9-]{0,61}[a-z0-9])?\.)+[a-z]{2,63}$", max_length=253)
]
CompletionCode = Annotated[str, Field(pattern=r"^[A-Za-z0-9-]{4,40}$")]


def _check_address(address: str) -> str:
    if not address.startswith("https://"):
        raise ValueError("an address to send participants to must begin with https://")
    if _ADDRESS.fullmatch(address) is None:
        raise ValueError(
            "an address is https://, a host name without port or user name, and a path without "
            "spaces"
        )
    return address


RedirectAddress = Annotated[str, Field(max_length=500), AfterValidator(_check_address)]


class PanelIdRefused(InvalidValue):
    """A join link lacks the panel's number of the person, or carries one of no use."""


class TookPartAlready(WrongMoment):
    """The participation of this person of the panel is over."""

    def __init__(self) -> None:
        super().__init__(
            "somebody with your number on the recruitment panel has taken part already, and that "
            "participation is over",
            next_step="Your personal link, if you kept it, still shows how it ended and your "
            "code. If you think that this is a mistake, write to the researchers.",
        )


class Panel(Record):
    """The parameters of the join link that are kept, and the hosts that may be gone back to.

    `identifier` is the parameter that tells one person from another, by default the first. Two
    links with the same value of it are one participation; blanks around it do not count, and
    `ignore_case` says whether capitals do. `required`: nobody joins without it.
    """

    parameters: Annotated[tuple[ParameterName, ...], Field(max_length=20)] = PROLIFIC
    identifier: str = ""
    required: bool = False
    ignore_case: bool = False
    hosts: Annotated[tuple[HostName, ...], Field(max_length=20)] = ()

    @model_validator(mode="after")
    def _check_parameters(self) -> Self:
        problems = [
            Problem(
                ("parameters", later), self.parameters[later], "this parameter is named already"
            )
            for later, _ in find_twins(self.parameters)
        ]
        problems += [
            Problem(("parameters", index), name, "this name is used by the join form itself")
            for index, name in enumerate(self.parameters)
            if name in RESERVED
        ]
        if self.required and not self.parameters:
            told = "there is no parameter that could be required"
            problems.append(Problem(("required",), True, told))
        if self.identifier and self.identifier not in self.parameters:
            allowed = f"use one of `parameters`: {', '.join(self.parameters) or 'there are none'}"
            problems.append(Problem(("identifier",), self.identifier, allowed))
        refuse(problems)
        return self

    @property
    def person_parameter(self) -> str | None:
        """The parameter that holds the panel's number for a person, if there is one."""
        return self.identifier or (self.parameters[0] if self.parameters else None)

    def read_ids(self, given: Mapping[str, str]) -> dict[str, str]:
        """The parameters of a join link that are kept; empty and unfilled ones count as missing.

        Raises `PanelIdRefused` for one that is too long, or if the required one is missing.
        """
        ids = {}
        for name in self.parameters:
            value = given.get(name, "").replace("\x00", "").strip()
            if len(value) > LONGEST_ID:
                raise PanelIdRefused(
                    f"the value of {name} in this link is longer than {LONGEST_ID} characters",
                    next_step="Open the study again from the page of your recruitment panel.",
                )
            if value and _UNFILLED.fullmatch(value) is None:
                ids[name] = value
        if self.required and self.person_parameter not in ids:
            raise PanelIdRefused(
                f"this link does not say who you are on your recruitment panel "
                f"({self.person_parameter} is missing)",
                next_step="Open the study from the page of your recruitment panel, by its own "
                "button, rather than by a link that was passed on or typed.",
            )
        return ids

    def person_id(self, ids: Mapping[str, str]) -> str | None:
        """What tells this person from others, as it is compared; None if the link had none."""
        value = ids.get(self.person_parameter or "")
        return value.lower() if value and self.ignore_case else value


class Ending(Record):
    """What belongs to one outcome: the code to show and, if any, the address to go to.

    In the address, `{code}` stands for the code and `{NAME}` for a parameter of the panel.
    """

    code: CompletionCode
    redirect: RedirectAddress | None = None

    @property
    def host(self) -> str | None:
        """The host of the address, in lower case."""
        match = _ADDRESS.fullmatch(self.redirect or "")
        return match["host"].lower() if match else None

    @property
    def blanks(self) -> tuple[str, ...]:
        """What the address wants to have filled in."""
        return tuple(_BLANK.findall(self.redirect or ""))

    def address(self, panel_ids: Mapping[str, str]) -> str | None:
        """The address with everything filled in and percent-encoded; what is unknown is empty."""
        if self.redirect is None:
            return None
        known = {**panel_ids, "code": self.code}
        return _BLANK.sub(lambda blank: _encode(known.get(blank[1], "")), self.redirect)


def _encode(text: str) -> str:
    return "".join(
        letter if letter in _PLAIN else "".join(f"%{byte:02X}" for byte in letter.encode())
        for letter in text
    )
