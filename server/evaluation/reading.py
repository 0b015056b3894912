"""Reading what `varil learn` and `varil simulate` wrote, strictly: a wrong table is named.

Only simulated rows are taken, since every figure made of them says so.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from server.headless.trials import POLICY_FILE, STUDY_ID
from server.policy_files import read_policy_file
from study.analysis.curves import LINES, MEASURES
from study.analysis.intervals import Floats
from study.errors import InvalidValue
from study.learning.policy import Policy

DISCREPANCIES = "discrepancies.csv"
POLICIES = "policies"
TRIALS = "trials.csv"
TIMES = ("sum_wait_s", "sum_completion_s", "slowest_robot_s")
_TRIAL_COLUMNS = (
    "study_id", "mode", "participant_code", "condition", "scale", "config_hash", "policy_sha256",
    "seed", "status", *TIMES,
)  # fmt: skip
_AGAIN = "Run `varil learn` again; its folder must stay complete."
_COUNTS = ("iteration", "line", "origin", *MEASURES)


@dataclass(frozen=True, eq=False)
class LearnedRun:
    """Output of `learn`. `settings`: of its last policy; `found[measure][line]`: float64[J]."""

    folder: Path
    settings: Mapping[str, Any]
    found: Mapping[str, Mapping[str, Floats]]


@dataclass(frozen=True, eq=False)
class TrialSet:
    """Output of `simulate`. `times[measure][seed]` in seconds; `timed_out`: trials at their cap."""

    folder: Path
    condition: str
    worker: str
    scale: str
    config_hash: str
    policy: Policy | None
    times: Mapping[str, Mapping[int, float]]
    timed_out: int


def find_folders(places: Sequence[Path]) -> list[Path]:
    """Folders with output of either verb: the places themselves, or else what lies below them.

    Errors: InvalidValue for a place that does not exist or holds no such output.
    """
    found: dict[Path, None] = {}
    for place in places:
        if not place.is_dir():
            raise InvalidValue(
                "there is no such folder", where=str(place), next_step="Check the path."
            )
        mine = [folder for folder in (place, *sorted(place.rglob("*"))) if _holds_output(folder)]
        if not mine:
            raise InvalidValue(
                f"the folder holds neither {DISCREPANCIES} nor {TRIALS}",
                where=str(place),
                next_step="Give folders that `varil learn --out` or `varil simulate --out` filled.",
            )
        found |= dict.fromkeys(folder.resolve() for folder in mine)
    return list(found)


def read_learned(folder: Path) -> LearnedRun:
    """Read a folder of `learn`. Errors: InvalidValue, PolicyError naming file and place."""
    files = sorted((folder / POLICIES).glob("*.json"))
    policy = read_policy_file(files[-1]) if files else None
    if policy is None or policy.training is None:
        raise InvalidValue(
            "there is no learned policy in it",
            where=str(folder / POLICIES),
            next_step=_AGAIN,
        )
    settings = dict(policy.training["settings"]) | {"origin": policy.origin}
    return LearnedRun(folder, settings, _read_series(folder / DISCREPANCIES))


def _read_series(path: Path) -> dict[str, dict[str, Floats]]:
    """Every measure of every line, iteration by iteration."""
    series: dict[str, dict[str, list[float]]] = {name: {} for name in MEASURES}
    for number, row in read_rows(path, _COUNTS):
        _require(row, "origin", ("simulated",), path, number)
        _require(row, "line", tuple(LINES), path, number)
        for name in MEASURES:
            mine = series[name].setdefault(row["line"], [])
            mine.append(_number(row, name, path, number))
        if row["iteration"] != str(len(mine) - 1):
            raise InvalidValue(
                f"iteration {row['iteration'][:20]} of “{row['line']}” stands where "
                f"{len(mine) - 1} was expected",
                where=f"{path}, line {number}",
                next_step=_AGAIN,
            )
    lengths = {len(values) for lines in series.values() for values in lines.values()}
    if len(lengths) != 1 or len(series["disable"]) != len(LINES):
        raise InvalidValue(
            f"wanted as many iterations of each of {', '.join(LINES)}",
            where=str(path),
            next_step=_AGAIN,
        )
    return {
        name: {line: np.array(values) for line, values in lines.items()}
        for name, lines in series.items()
    }


def read_trials(folder: Path) -> TrialSet:
    """Read a folder of `simulate`. Errors: InvalidValue, PolicyError naming file and place."""
    path = folder / TRIALS
    times: dict[str, dict[int, float]] = {name: {} for name in TIMES}
    kinds: set[tuple[str, ...]] = set()
    timed_out = 0
    for line, row in read_rows(path, _TRIAL_COLUMNS):
        if (row["study_id"], row["mode"]) != (STUDY_ID, "bot"):
            raise InvalidValue(
                "these rows do not come from `varil simulate`",
                where=f"{path}, line {line}",
                next_step="Use `varil analyze` for the data of a study.",
            )
        _require(row, "status", ("completed", "timed_out"), path, line)
        seed = int(_number(row, "seed", path, line))
        if seed in times[TIMES[0]]:
            raise InvalidValue(f"seed {seed} stands there twice", where=f"{path}, line {line}")
        for name in TIMES:
            times[name][seed] = _number(row, name, path, line)
        timed_out += row["status"] == "timed_out"
        names = ("condition", "participant_code", "scale", "config_hash", "policy_sha256")
        kinds.add(tuple(row[name] for name in names))
    if len(kinds) != 1:
        raise InvalidValue(
            "the rows mix conditions, workers, scales, settings or policies",
            where=str(path),
            next_step="Keep the output of each `varil simulate` in a folder of its own.",
        )
    condition, worker, scale, config_hash, sha256 = kinds.pop()
    policy = _read_decider(folder, sha256) if condition == "varil" else None
    return TrialSet(folder, condition, worker, scale, config_hash, policy, times, timed_out)


def read_rows(path: Path, columns: Sequence[str]) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield line number and cells of each row of a CSV file.

    Errors: InvalidValue for a file that is no such table, naming the columns it lacks, for a row
    of another width, and for a table without rows.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file, restkey="")
            missing = [name for name in columns if name not in (reader.fieldnames or ())]
            if missing:
                raise InvalidValue(
                    f"the table lacks {', '.join(missing)}",
                    where=str(path),
                    next_step="Make it again with this version of the program.",
                )
            empty = True
            for row in reader:
                empty = False
                if None in row.values() or "" in row:
                    raise InvalidValue(
                        "the row has another number of cells than the header",
                        where=f"{path}, line {reader.line_num}",
                        next_step="The file may be cut off; make it again.",
                    )
                yield reader.line_num, row
    except (UnicodeDecodeError, csv.Error) as problem:
        raise InvalidValue(f"this is no CSV table ({problem})", where=str(path)) from problem
    if empty:
        raise InvalidValue(
            "the table has no rows", where=str(path), next_step="Make it again, or leave it out."
        )


def _holds_output(folder: Path) -> bool:
    return (folder / DISCREPANCIES).is_file() or (folder / TRIALS).is_file()


def _read_decider(folder: Path, sha256: str) -> Policy:
    """The policy that decided in these trials, as kept beside them."""
    policy = read_policy_file(folder / POLICY_FILE)
    if policy.sha256 != sha256:
        raise InvalidValue(
            f"the trials ran with the policy {sha256[:12]}, the file holds {policy.sha256[:12]}",
            where=str(folder / POLICY_FILE),
            next_step="Run `varil simulate` again.",
        )
    return policy


def _require(
    row: Mapping[str, str], column: str, allowed: Sequence[str], path: Path, line: int
) -> None:
    if row[column] not in allowed:
        raise InvalidValue(
            f"{column} is “{row[column][:40]}”",
            where=f"{path}, line {line}",
            next_step=f"Allowed here: {', '.join(allowed)}.",
        )


def _number(row: Mapping[str, str], column: str, path: Path, line: int) -> float:
    try:
        value = float(row[column])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InvalidValue(
            f"{column} is “{row[column][:40]}”, wanted a number", where=f"{path}, line {line}"
        )
    return value
