"""Policy files on disk: the one that is shipped and any other."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from study.errors import PolicyError
from study.learning.policy import Policy, read_policy

MAX_BYTES = 1_000_000
SHIPPED = "person-1-240.json"


def read_policy_file(path: Path) -> Policy:
    """The policy in a file; PolicyError names the file and what is wrong with it."""
    try:
        data = path.read_bytes() if path.stat().st_size <= MAX_BYTES else None
    except OSError as problem:
        raise PolicyError(
            f"the policy file cannot be read ({problem.strerror})",
            where=str(path),
            next_step="Check the path and its permissions.",
        ) from problem
    if data is None:
        raise PolicyError(
            f"the file is larger than {MAX_BYTES} bytes, so it is no policy",
            where=str(path),
            next_step="Give a file that `varil learn` wrote or a learning run offers.",
        )
    try:
        return read_policy(data)
    except PolicyError as problem:
        where = f"{path}, {problem.where}" if problem.where else str(path)
        raise PolicyError(problem.what, where=where, next_step=problem.next_step) from problem


def read_policy_upload(data: bytes) -> Policy:
    """The policy in an uploaded file; PolicyError says what is wrong with it."""
    if not data:
        raise PolicyError("the file is empty", next_step="Choose a policy file.")
    if len(data) > MAX_BYTES:
        raise PolicyError(
            f"the file is larger than {MAX_BYTES} bytes, so it is no policy",
            next_step="Choose a policy file.",
        )
    return read_policy(data)


def shipped_policy() -> Policy:
    """The policy that comes with the software, learned from simulated people (docs/learning.md)."""
    return read_policy(resources.files("study.policies").joinpath(SHIPPED).read_bytes())
