"""The launch checklist: what a rehearsal must have shown before anybody is invited.

All of it is read from the export's zip and the report, as an analyst would, not from the server.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from server.analysis.bundle import Row, read_bundle
from server.analysis.files import REPORT
from server.rehearsal.person import Story
from study.errors import StudyError


@dataclass(frozen=True)
class Check:
    """One line of the checklist: what must hold, whether it does, and the figures."""

    what: str
    passed: bool
    figures: str


@dataclass(frozen=True)
class Evidence:
    """What a rehearsal left: the study as the server tells it, the stories, the zip, the report."""

    study: Mapping[str, Any]
    stories: Sequence[Story]
    problems: Sequence[str]
    file: Path
    report: Path

    @property
    def completed(self) -> set[str]:
        """Codes of those who reached the last page."""
        return {story.code for story in self.stories if story.end == "completed"}

    @cached_property
    def tables(self) -> Mapping[str, list[Row]]:
        """The zip's tables, every file held against the manifest; raises StudyError."""
        return read_bundle(self.file, "bot").rows

    def rows_of(self, table: str) -> dict[str, list[Row]]:
        """Rows of this rehearsal's participants by code."""
        found: dict[str, list[Row]] = {story.code: [] for story in self.stories}
        for row in self.tables[table]:
            if row["participant_code"] in found:
                found[row["participant_code"]].append(row)
        return found


def check_rehearsal(evidence: Evidence) -> list[Check]:
    """Every check; one that cannot be made has failed, with the reason as its figures."""
    checks = []
    for what, look in _CHECKS.items():
        try:
            passed, figures = look(evidence)
        except (StudyError, OSError) as error:
            passed, figures = False, str(error)
        checks.append(Check(what, passed, figures))
    return checks


def _no_errors(evidence: Evidence) -> tuple[bool, str]:
    return not evidence.problems, f"{len(evidence.problems)} errors"


def _everybody_ended(evidence: Evidence) -> tuple[bool, str]:
    staying = [story for story in evidence.stories if story.role.fate == "stays"]
    ended = sum(story.end == "completed" for story in staying)
    return ended == len(staying), f"{ended} of {len(staying)} reached the last page"


def _ends_are_stored(evidence: Evidence) -> tuple[bool, str]:
    wanted = {"completed": "completed", "dropped": "timed-out", "withdrew": "withdrawn"}
    stored = {code: rows[0]["status"] for code, rows in evidence.rows_of("participants.csv").items()
              if rows}  # fmt: skip
    wrong = [s.code for s in evidence.stories if stored.get(s.code) != wanted.get(s.end, "")]
    counts = ", ".join(f"{n} {status}" for status, n in sorted(Counter(stored.values()).items()))
    return not wrong, counts + (f"; not as seen: {', '.join(wrong[:5])}" if wrong else "")


def _all_rows(evidence: Evidence) -> tuple[bool, str]:
    """As many trials as there are conditions, and the answers to the very same items."""
    conditions = len(evidence.study["conditions"])
    trials, answers = evidence.rows_of("trials.csv"), evidence.rows_of("responses.csv")
    asked = {(row["position"], row["instrument"], row["item"])
             for code in evidence.completed for row in answers[code]}  # fmt: skip
    short = [
        code
        for code in sorted(evidence.completed)
        if len(trials[code]) != conditions
        or {row["condition"] for row in trials[code]} != set(evidence.study["conditions"])
        or len(answers[code]) != len(asked)
    ]
    figures = f"{conditions} trials and {len(asked)} answers each"
    return not short, figures + (f"; not of {', '.join(short[:5])}" if short else "")


def _trials_completed(evidence: Evidence) -> tuple[bool, str]:
    rows = evidence.rows_of("trials.csv")
    ends = Counter(row["status"] for code in evidence.completed for row in rows[code])
    return set(ends) <= {"completed"}, ", ".join(f"{n} {end}" for end, n in sorted(ends.items()))


def _cells(evidence: Evidence) -> tuple[bool, str]:
    """Over all completed simulated participants of this version of the study."""
    here = evidence.study["config_hash"]
    counts = Counter(
        row["condition_order"]
        for row in evidence.tables["participants.csv"]
        if row["status"] == "completed" and row["config_hash"] == here
    )
    cells = [counts[">".join(order)] for order in evidence.study["orders"]]
    return max(cells) - min(cells) <= 1, f"{min(cells)} to {max(cells)} in {len(cells)} cells"


def _places(evidence: Evidence) -> tuple[bool, str]:
    """No gap: of each order the blocks 0, 1, 2 ... are taken by those who completed."""
    here = evidence.study["config_hash"]
    taken: dict[str, list[int]] = {}
    for row in evidence.tables["participants.csv"]:
        if row["status"] == "completed" and row["config_hash"] == here:
            taken.setdefault(row["condition_order"], []).append(int(row["block"]))
    gaps = sum(sorted(blocks) != list(range(len(blocks))) for blocks in taken.values())
    left = sum(story.end in ("dropped", "withdrew") for story in evidence.stories)
    return gaps == 0, f"{left} left; orders with a gap: {gaps}"


def _marked(evidence: Evidence) -> tuple[bool, str]:
    rows = [row for table in ("participants.csv", "trials.csv", "responses.csv")
            for row in evidence.tables[table]]  # fmt: skip
    marked = sum(row["mode"] == "bot" and row["is_bot"].lower() in ("true", "1") for row in rows)
    return marked == len(rows), f"{marked} of {len(rows)} rows say so"


def _manifest(evidence: Evidence) -> tuple[bool, str]:
    rows = sum(map(len, evidence.tables.values()))
    return (
        True,
        f"{evidence.file.name}, {evidence.file.stat().st_size // 1024} kB, {rows} rows read",
    )


def _report(evidence: Evidence) -> tuple[bool, str]:
    page = evidence.report / REPORT
    return page.is_file(), str(page)


_CHECKS: Mapping[str, Callable[[Evidence], tuple[bool, str]]] = {
    "Pages and sockets answered as they should": _no_errors,
    "Everybody who stayed reached the end": _everybody_ended,
    "The data tell of each the end that was seen": _ends_are_stored,
    "The export's manifest holds": _manifest,
    "All who completed have all their rows": _all_rows,
    "No trial ran out of time": _trials_completed,
    "Cells differ by at most one": _cells,
    "Places of those who left were filled again": _places,
    "Every row is marked as simulated": _marked,
    "The report is made": _report,
}
