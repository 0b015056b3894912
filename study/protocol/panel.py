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

from study.protocol.records import Problem, Record, find_twins, refuse

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


class Panel(Record):
    """The parameters of the join link that are kept, and the hosts that may be gone back to.

    `identifier` is the parameter that tells one person from another, by default the first.
    """

    parameters: Annotated[tuple[ParameterName, ...], Field(max_length=20)] = PROLIFIC
    identifier: str = ""
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
        if self.identifier and self.identifier not in self.parameters:
            allowed = f"use one of `parameters`: {', '.join(self.parameters) or 'there are none'}"
            problems.append(Problem(("identifier",), self.identifier, allowed))
        refuse(problems)
        return self

    @property
    def person_parameter(self) -> str | None:
        """The parameter that holds the panel's number for a person, if there is one."""
        return self.identifier or (self.parameters[0] if self.parameters else None)


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
