"""From the cells of an export to the people, trials and answers of an analysis.

What exclusion rules of the study mark is left out unless it is asked to be kept.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence

from server.analysis.bundle import Bundle, BundleError, Row
from study.analysis.cases import MEASURES, SCORE, Answer, Item, Person, StudyData, TrialCase
from study.analysis.wording import count

Marks = Mapping[tuple[str, str], str]
"""Rules that trials break, by participant and position."""


def read_study(bundle: Bundle, *, keep_marked: bool = False) -> StudyData:
    """The study's data of the bundle's mode.

    `keep_marked` counts what exclusion rules mark, but not those whom staff excluded. Errors:
    BundleError naming file, row and column.
    """
    people = bundle.rows["participants.csv"]
    codes = Counter(row["participant_code"] for row in people)
    for code, times in sorted(codes.items()):
        if not code or times > 1:
            raise BundleError(
                f"the participant code “{code[:20]}” stands in {count(times, 'row')}",
                where=f"{bundle.name}, participants.csv",
                next_step="Analyse one export of one study.",
            )
    if len({row["study_id"] for row in people}) > 1:
        raise BundleError(
            "the rows come from more than one study",
            where=f"{bundle.name}, participants.csv",
            next_step="Analyse one export of one study.",
        )
    marks = {
        (row["participant_code"], row["position"]): _rules(row)
        for row in bundle.rows.get("quality.csv", [])
        if row.get("flags")
    }
    known = set(codes)
    items = _items(bundle)
    return StudyData(
        study_id=people[0]["study_id"] if people else "",
        mode=bundle.mode,
        versions=tuple(sorted({row["config_hash"] for row in people})),
        people=tuple(_person(row, keep_marked) for row in people),
        trials=tuple(_trials(bundle, known, {} if keep_marked else marks)),
        answers=(*_answers(bundle, known), *_scores(bundle, items)),
        items=(*items, *_score_items(bundle, items)),
        marked_people=sum(bool(row.get("flags")) for row in people),
        marked_trials=len(marks),
        keeps_marked=keep_marked,
    )


def _person(row: Row, keep_marked: bool) -> Person:
    reason = ""
    if row["status"] == "excluded":
        reason = row.get("status_reason") or "no reason given"
    elif row.get("flags") and not keep_marked:
        reason = _rules(row)
    return Person(row["participant_code"], row["status"], row.get("condition_order", ""), reason)


def _rules(row: Row) -> str:
    return f"marked by {', '.join(row['flags'].split('|'))}"


def _trials(bundle: Bundle, known: set[str], marks: Marks) -> list[TrialCase]:
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
                marked=marks.get((row["participant_code"], row["position"]), ""),
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
        if row["file"] != "responses.csv" or "." not in row["name"] or row["name"] in found:
            continue
        instrument, name = row["name"].split(".", 1)
        levels = tuple(
            (level.split("=", 1)[0], level.split("=", 1)[-1])
            for level in row["levels"].split("|")
            if level
        )
        found[row["name"]] = Item(instrument, name, row["type"], row["meaning"], levels)
    return list(found.values())


def _score_column(instrument: str, condition: str) -> str:
    return f"{instrument}_{SCORE}_{condition}"


def _score_items(bundle: Bundle, items: Sequence[Item]) -> list[Item]:
    """An item for each instrument whose score stands in wide.csv once per condition."""
    columns = {column for row in bundle.rows.get("wide.csv", [])[:1] for column in row}
    conditions = {row["condition"] for row in bundle.rows["trials.csv"]}
    return [
        Item(name, SCORE, SCORE, f"score of {name}")
        for name in dict.fromkeys(item.instrument for item in items)
        if any(_score_column(name, condition) in columns for condition in conditions)
    ]


def _scores(bundle: Bundle, items: Sequence[Item]) -> list[Answer]:
    """The scores after each trial, as answers."""
    conditions = sorted({row["condition"] for row in bundle.rows["trials.csv"]})
    positions = {
        (row["participant_code"], row["condition"]): int(row["position"])
        for row in bundle.rows["trials.csv"]
    }
    found = []
    for row in bundle.rows.get("wide.csv", []):
        code = row["participant_code"]
        for item in _score_items(bundle, items):
            for condition in conditions:
                value = row.get(_score_column(item.instrument, condition), "")
                place = positions.get((code, condition))
                if value and place:
                    found.append(Answer(code, condition, place, item.instrument, SCORE, value))
    return found


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
