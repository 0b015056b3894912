"""From the cells of an export to the people, trials and answers of an analysis.

Columns that older exports lack (`excluded`, quality.csv) are optional.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from server.analysis_bundle import Bundle, BundleError, Row
from study.analysis.cases import MEASURES, Answer, Item, Person, StudyData, TrialCase

_REASONS = ("excluded_reason", "exclusion_reason", "reason", "status_reason", "flags", "rule")
_NO = frozenset({"", "false", "0", "no", "f", "n"})


def read_study(bundle: Bundle) -> StudyData:
    """The study's data of the bundle's mode. Errors: BundleError naming file, row and column."""
    people = bundle.rows["participants.csv"]
    codes = Counter(row["participant_code"] for row in people)
    for code, times in sorted(codes.items()):
        if not code or times > 1:
            raise BundleError(
                f"{times} rows have the participant code “{code[:20]}”",
                where=f"{bundle.name}, participants.csv",
                next_step="Analyse one export of one study.",
            )
    if len({row["study_id"] for row in people}) > 1:
        raise BundleError(
            "the rows come from more than one study",
            where=f"{bundle.name}, participants.csv",
            next_step="Analyse one export of one study.",
        )
    flagged = _flagged(bundle.rows.get("quality.csv", []))
    known = set(codes)
    return StudyData(
        study_id=people[0]["study_id"] if people else "",
        mode=bundle.mode,
        versions=tuple(sorted({row["config_hash"] for row in people})),
        people=tuple(_person(row, flagged) for row in people),
        trials=tuple(_trials(bundle, known)),
        answers=tuple(_answers(bundle, known)),
        items=tuple(_items(bundle)),
    )


def _person(row: Row, flagged: dict[str, str]) -> Person:
    code = row["participant_code"]
    reason = _exclusion(row) or flagged.get(code, "")
    if row["status"] == "excluded" and not reason:
        reason = _told_reason(row) or "no reason given"
    return Person(code, row["status"], row.get("condition_order", ""), reason)


def _exclusion(row: Row) -> str:
    flag = row.get("excluded", "").strip()
    if flag.lower() in _NO:
        return ""
    own = flag if flag.lower() not in {"true", "1", "yes", "t", "y"} else ""
    return _told_reason(row) or own or "no reason given"


def _told_reason(row: Row) -> str:
    return next((row[name] for name in _REASONS if row.get(name)), "")


def _flagged(rows: Sequence[Row]) -> dict[str, str]:
    """Reasons by participant; a participant may have several rows."""
    found: dict[str, list[str]] = {}
    for row in rows:
        if reason := _exclusion(row):
            reasons = found.setdefault(row.get("participant_code", ""), [])
            if reason not in reasons:
                reasons.append(reason)
    return {code: "; ".join(reasons) for code, reasons in found.items()}


def _trials(bundle: Bundle, known: set[str]) -> list[TrialCase]:
    found = []
    for number, row in enumerate(bundle.rows["trials.csv"], 1):
        where = f"{bundle.name}, trials.csv, row {number} of mode {bundle.mode}"
        _check_person(row, known, where)
        values = {name: _number(row, name, where) for name in MEASURES}
        if not row["condition"]:
            raise BundleError("the trial has no condition", where=where)
        found.append(
            TrialCase(
                participant=row["participant_code"],
                condition=row["condition"],
                position=_position(row, where),
                status=row["status"],
                values={name: value for name, value in values.items() if value is not None},
            )
        )
    return found


def _answers(bundle: Bundle, known: set[str]) -> list[Answer]:
    found = []
    for number, row in enumerate(bundle.rows["responses.csv"], 1):
        where = f"{bundle.name}, responses.csv, row {number} of mode {bundle.mode}"
        _check_person(row, known, where)
        found.append(
            Answer(
                participant=row["participant_code"],
                condition=row["condition"],
                position=_position(row, where) if row["position"] else None,
                instrument=row["instrument"],
                item=row["item"],
                value=row["value"],
            )
        )
    return found


def _items(bundle: Bundle) -> list[Item]:
    """The items of the codebook, each once, as the first version words it."""
    found: dict[str, Item] = {}
    for row in bundle.rows["codebook.csv"]:
        if "." not in row["name"] or row["name"] in found:
            continue
        instrument, name = row["name"].split(".", 1)
        levels = tuple(
            (level.split("=", 1)[0], level.split("=", 1)[-1])
            for level in row["levels"].split("|")
            if level
        )
        found[row["name"]] = Item(instrument, name, row["type"], row["meaning"], levels)
    return list(found.values())


def _check_person(row: Row, known: set[str], where: str) -> None:
    if row["participant_code"] not in known:
        raise BundleError(
            f"the participant “{row['participant_code'][:20]}” has no row in participants.csv",
            where=where,
            next_step="Export the data again.",
        )


def _number(row: Row, column: str, where: str) -> float | None:
    """A finite figure of at least 0, or None for an empty cell."""
    if row[column] == "":
        return None
    try:
        value = float(row[column])
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or value < 0:
        raise BundleError(
            f"{column} is “{row[column][:20]}”, and no number of seconds",
            where=where,
            next_step="Give the zip as it was exported.",
        )
    return value


def _position(row: Row, where: str) -> int:
    if not row["position"].isdecimal() or int(row["position"]) < 1:
        raise BundleError(
            f"position is “{row['position'][:20]}”, and no whole number from 1",
            where=where,
            next_step="Give the zip as it was exported.",
        )
    return int(row["position"])
