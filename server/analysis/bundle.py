"""Reading an export's zip for analysis: complete, unchanged, and of one mode.

Every file is checked against MANIFEST.sha256 before a number of it is believed.
"""

from __future__ import annotations

import csv
import hashlib
import io
import re
import zipfile
import zlib
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from study.errors import InvalidValue

Row = dict[str, str]
MANIFEST = "MANIFEST.sha256"
NEEDED: Mapping[str, tuple[str, ...]] = {
    "participants.csv": ("participant_code", "study_id", "config_hash", "mode", "status"),
    "trials.csv": (
        "participant_code", "mode", "position", "condition", "status", "sum_wait_s",
        "sum_completion_s", "slowest_robot_s",
    ),
    "responses.csv": (
        "participant_code", "mode", "position", "condition", "instrument", "item", "value",
    ),
    "codebook.csv": ("file", "name", "type", "meaning", "levels"),
}  # fmt: skip
"""Files that an analysis needs, and their columns that it reads."""
OPTIONAL = ("quality.csv", "wide.csv")
MODES = ("live", "pilot", "bot")
_PIECE = 1 << 20


class BundleError(InvalidValue):
    """An export's zip cannot be analysed: damaged, changed, or without what is needed."""


@dataclass(frozen=True)
class Bundle:
    """The rows of one mode by file, with the zip's name and SHA-256.

    `others` tells how many participants of other modes the zip holds, who are not in `rows`.
    """

    name: str
    sha256: str
    mode: str
    rows: Mapping[str, list[Row]]
    others: Mapping[str, int]


def read_bundle(path: Path, mode: str | None = None) -> Bundle:
    """Read and check a zip; without `mode` the live participants, else the only mode present.

    Errors: BundleError naming the file, column or mode that is wrong; OSError if unreadable.
    """
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    try:
        with zipfile.ZipFile(path) as archive:
            _check_manifest(path, archive)
            tables = {name: _read_table(path, archive, name) for name in NEEDED}
            present = set(archive.namelist())
            tables |= {
                name: _read_table(path, archive, name) for name in OPTIONAL if name in present
            }
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError) as error:
        raise BundleError(
            f"this is not a complete zip ({error})",
            where=str(path),
            next_step="Download or export the data again.",
        ) from error
    return _choose_mode(path, digest, tables, mode)


def _check_manifest(path: Path, archive: zipfile.ZipFile) -> None:
    names = set(archive.namelist())
    for needed in (MANIFEST, *NEEDED):
        if needed not in names:
            raise BundleError(
                f"the zip has no {needed}",
                where=str(path),
                next_step="Give a zip as `varil export` writes it.",
            )
    listed: dict[str, str] = {}
    for line in archive.read(MANIFEST).decode("utf-8", "replace").splitlines():
        match = re.fullmatch(r"([0-9a-f]{64}) [ *](.+)", line)
        if not match:
            raise BundleError(
                f"{MANIFEST} has a line that is no checksum",
                where=str(path),
                next_step="Download or export the data again.",
            )
        listed[match[2]] = match[1]
    for name in sorted(names - {MANIFEST}):
        if name in listed and _digest(archive, name) == listed[name]:
            continue
        if name in listed or name in {*NEEDED, *OPTIONAL}:
            raise BundleError(
                f"{name} is not the file that {MANIFEST} vouches for",
                where=str(path),
                next_step="It was changed or damaged after the export; export the data again.",
            )


def _digest(archive: zipfile.ZipFile, name: str) -> str:
    digest = hashlib.sha256()
    with archive.open(name) as file:
        while piece := file.read(_PIECE):
            digest.update(piece)
    return digest.hexdigest()


def _read_table(path: Path, archive: zipfile.ZipFile, name: str) -> list[Row]:
    where = f"{path}, {name}"
    try:
        text = archive.read(name).decode("utf-8-sig")
        lines = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise BundleError(
            f"this is no table in UTF-8 ({error})",
            where=where,
            next_step="Give the zip as it was exported, not one saved by a spreadsheet.",
        ) from error
    header = lines[0] if lines else []
    missing = [column for column in NEEDED.get(name, ()) if column not in header]
    if missing:
        raise BundleError(
            f"the column{'s' if len(missing) > 1 else ''} {', '.join(missing)} "
            f"{'are' if len(missing) > 1 else 'is'} missing",
            where=where,
            next_step="Give a zip as `varil export` writes it.",
        )
    rows: list[Row] = []
    for number, cells in enumerate(lines[1:], 2):
        if not cells:
            continue
        if len(cells) != len(header):
            raise BundleError(
                f"row {number} has {len(cells)} cells and the header has {len(header)}",
                where=where,
                next_step="Give the zip as it was exported, not one saved by a spreadsheet.",
            )
        rows.append(dict(zip(header, cells, strict=True)))
    return rows


def _choose_mode(
    path: Path, digest: str, tables: Mapping[str, list[Row]], mode: str | None
) -> Bundle:
    found = Counter(row["mode"] for row in tables["participants.csv"])
    if strange := set(found) - set(MODES):
        raise BundleError(
            f"the mode “{min(strange)[:20]}” is not known",
            where=f"{path}, participants.csv",
            next_step=f"A participant's mode is one of {', '.join(MODES)}.",
        )
    told = ", ".join(f"{name} ({found[name]} participants)" for name in MODES if found[name])
    if mode is None and found and not found["live"] and len(found) > 1:
        raise BundleError(
            f"no live participants, but {told}",
            where=str(path),
            next_step="Choose one with --mode; modes are never mixed.",
        )
    if mode is not None and found and not found[mode]:
        raise BundleError(
            f"no participants of mode {mode}; the zip holds {told}",
            where=str(path),
            next_step="Choose another --mode.",
        )
    chosen = mode or next((name for name in MODES if found[name]), "")
    rows = {
        name: [row for row in table if row.get("mode", chosen) == chosen]
        for name, table in tables.items()
    }
    others = {name: found[name] for name in MODES if found[name] and name != chosen}
    return Bundle(path.name, digest, chosen, rows, others)
