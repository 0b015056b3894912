"""Study files on disk: read with the policy they name, and begun with `varil init`.

A study's policy is frozen with it: its hash stands in the record, its file is stored.
"""

from __future__ import annotations

import secrets
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from study.config import Study
from study.errors import InvalidValue, PolicyError, StudyFileError
from study.files.demo import demo_text, paper_study
from study.files.reading import LONGEST_CHARACTERS, read_study
from study.protocol.consistency import SECRET
from study.protocol.records import Problem

if TYPE_CHECKING:
    from study.learning.policy import Policy

STUDY_NAME, README_NAME = "study.toml", "README.md"
_CODE_LETTERS = "23456789ABCDEFGHJKMNPQRSTVWXYZ"


@dataclass(frozen=True)
class ReadStudy:
    """A study with the policy that its file names, if it names one."""

    study: Study
    policy: Policy | None = None


def read_study_file(path: Path) -> ReadStudy:
    """The study in a file. Errors: StudyFileError with every problem; OSError."""
    where = str(path)
    study = read_study(_read_text(path), where)
    if not study.policy:
        _check_hash(study, where)
        return ReadStudy(study)
    policy = _read_policy(study, path)
    return ReadStudy(study.revised(policy_sha256=policy.sha256), policy)


def read_study_files(paths: Iterable[Path]) -> list[ReadStudy]:
    """The studies to serve, the demo study where no file is given.

    Errors: StudyFileError; InvalidValue where two files have the same `study_id`.
    """
    read: dict[str, ReadStudy] = {}
    files: dict[str, Path] = {}
    for path in paths:
        found = read_study_file(path)
        study_id = found.study.study_id
        if study_id in files:
            raise InvalidValue(
                f"{files[study_id]} and {path} both have the study_id “{study_id}”",
                next_step="Give each study a name of its own.",
            )
        read[study_id], files[study_id] = found, path
    return list(read.values()) or [ReadStudy(paper_study())]


def begin_study(folder: Path) -> list[Path]:
    """Write a study file and a README into an empty folder; codes for outcomes are drawn.

    Errors: InvalidValue where the folder holds something already; OSError.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InvalidValue(
            f"{folder} is not empty" if folder.is_dir() else f"{folder} is no folder",
            next_step="Name a folder that does not exist yet; nothing was written.",
        )
    folder.mkdir(parents=True, exist_ok=True)
    study_id = _id_from(folder.resolve().name)
    text = demo_text()
    for code in paper_study().completion_codes.values():
        text = text.replace(f'"{code}"', f'"{_draw_code()}"')
    text = text.replace('study_id = "demo" ', f'study_id = "{study_id}" ').replace(
        "/s/demo;", f"/s/{study_id};"
    )
    guide = resources.files("study.files").joinpath("start.md").read_text(encoding="utf-8")
    files = {
        folder / STUDY_NAME: text,
        folder / README_NAME: guide.replace("/s/demo", f"/s/{study_id}"),
    }
    for file, content in files.items():
        file.write_text(content, encoding="utf-8")
    return list(files)


def _read_text(path: Path) -> str:
    size = path.stat().st_size
    if size > 4 * LONGEST_CHARACTERS:
        raise StudyFileError([Problem((), size, "the file is too large to be a study")], str(path))
    try:
        return path.read_bytes().decode()
    except UnicodeDecodeError as error:
        message = f"the file is not UTF-8 text (byte {error.start})"
        raise StudyFileError([Problem((), None, message)], str(path)) from error


def _read_policy(study: Study, path: Path) -> Policy:
    from server.policy_files import read_policy_file  # compiles: only where a study names a policy

    try:
        policy = read_policy_file(path.parent / study.policy)
        policy.require_thresholds(study.thresholds)
    except PolicyError as error:
        raise StudyFileError(
            [Problem(("policy",), study.policy, error.sentence)], str(path)
        ) from error
    if study.policy_sha256 not in ("", policy.sha256):
        message = f"the policy in {study.policy} has another hash: {policy.sha256}"
        problem = Problem(("policy_sha256",), study.policy_sha256, message)
        raise StudyFileError([problem], str(path))
    return policy


def _check_hash(study: Study, where: str) -> None:
    """A hash without a file names a policy that nobody can read."""
    if study.policy_sha256:
        message = "name the policy's file by `policy` as well"
        raise StudyFileError([Problem(("policy_sha256",), study.policy_sha256, message)], where)


def _id_from(name: str) -> str:
    """A study_id made from a folder's name, or a plain one where that gives none."""
    words = "".join(letter if letter.isascii() and letter.isalnum() else "-" for letter in name)
    slug = "-".join(filter(None, words.lower().split("-")))[:40].strip("-")
    fits = slug[:1].isalpha() and not SECRET.search(slug)
    return slug if fits else "my-study"


def _draw_code() -> str:
    letters = [secrets.choice(_CODE_LETTERS) for _ in range(10)]
    return "".join(letters[:5]) + "-" + "".join(letters[5:])
