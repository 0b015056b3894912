"""Exports made up for tests: the true files and columns, with figures that are drawn."""

from __future__ import annotations

import csv
import hashlib
import io
import itertools
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from server.analysis.run import AnalysisOptions, analyze
from server.export.bundle import study_items
from study.files.demo import paper_study
from study.records.codebook import CODEBOOK, codebook_rows
from study.records.tables import TABLES

Rows = list[dict[str, str]]
STUDY = paper_study()
HASH = STUDY.config_hash
WISH = {"varil": 0.75, "arroch": 0.0, "crmiar": -0.1, "none": -0.6, "full": -0.3}
SHORTER = {"varil": np.log(0.86)}


@dataclass
class Bundle:
    """Tables by name, to be changed before they are written."""

    tables: dict[str, Rows] = field(default_factory=dict)
    headers: dict[str, list[str]] = field(default_factory=dict)

    def write(self, path: Path, lies: Mapping[str, str] | None = None) -> Path:
        """Write the zip; `lies` are checksums that the manifest tells instead of the true ones."""
        manifest = []
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, header in self.headers.items():
                out = io.StringIO()
                writer = csv.writer(out, lineterminator="\n")
                writer.writerow(header)
                writer.writerows([row[column] for column in header] for row in self.tables[name])
                data = out.getvalue().encode()
                digest = (lies or {}).get(name, hashlib.sha256(data).hexdigest())
                archive.writestr(f"{name}.csv", data)
                manifest.append(f"{digest}  {name}.csv\n")
            archive.writestr("MANIFEST.sha256", "".join(manifest))
        return path


def make_bundle(
    people: int = 24,
    *,
    mode: str = "bot",
    conditions: tuple[str, ...] = ("varil", "arroch", "crmiar"),
    seed: int = 4,
) -> Bundle:
    """People who all completed: log-normal times, `varil` 14 % shorter, a little practice."""
    rng = np.random.default_rng(seed)
    bundle = Bundle()
    for name, table in TABLES.items():
        bundle.headers[name], bundle.tables[name] = table.header, []
    bundle.headers["codebook"] = CODEBOOK.header
    bundle.tables["codebook"] = list(codebook_rows(study_items(HASH, STUDY)))
    orders = list(itertools.permutations(conditions))
    for number in range(people):
        add_person(bundle, rng, f"P{number:04}", mode, orders[number % len(orders)])
    return bundle


def add_person(
    bundle: Bundle, rng: np.random.Generator, code: str, mode: str, order: tuple[str, ...]
) -> None:
    """One completed participation."""
    same = {
        "participant_code": code,
        "study_id": "demo",
        "config_hash": HASH,
        "mode": mode,
        "is_bot": "true" if mode == "bot" else "false",
    }
    person = {"status": "completed", "step": "ended", "condition_order": ">".join(order)}
    bundle.tables["participants"].append(blank("participants") | same | person)
    skill, mood = rng.normal(0, 0.12), rng.normal(0, 0.5)
    for item, value in (
        ("age", str(rng.integers(19, 64))),
        ("gender", str(rng.choice(["woman", "man", "non_binary", "prefer_not_to_say"]))),
        ("games_3d", str(rng.choice(["never", "monthly", "weekly", "daily"]))),
    ):
        bundle.tables["responses"].append(
            blank("responses") | same | {"instrument": "demographics", "item": item, "value": value}
        )
    for position, condition in enumerate(order, 1):
        place = {"position": str(position), "condition": condition}
        log = 7.4 + skill - 0.04 * position + SHORTER.get(condition, 0.0) + rng.normal(0, 0.1)
        wait = float(np.exp(log))
        slowest = 330 + wait / 14 + float(rng.normal(0, 14))
        figures = {
            "status": "completed",
            "sum_wait_s": repr(wait),
            "sum_completion_s": repr(11.1 * slowest + float(rng.normal(0, 40))),
            "slowest_robot_s": repr(slowest),
            "trial_id": f"{code}-{position}",
        }
        bundle.tables["trials"].append(blank("trials") | same | place | figures)
        for place_of_item, item in enumerate(STUDY.questionnaire[0].items, 1):
            wish = WISH[condition] if place_of_item > 2 else 0.0
            value = int(np.clip(round(3.4 + mood + wish + rng.normal(0, 0.8)), 1, 5))
            answer = {"instrument": "questionnaire", "item": item.name, "value": str(value)}
            bundle.tables["responses"].append(blank("responses") | same | place | answer)


def blank(table: str) -> dict[str, str]:
    """A row of empty cells."""
    return dict.fromkeys(TABLES[table].header, "")


def analyse_bots(where: Path) -> Path:
    """Analyse 24 bots in a folder, of whom P0005 is excluded and P0002 lost a trial."""
    bundle = make_bundle(24)
    bundle.tables["participants"][5] |= {"status": "excluded"}
    bundle.tables["trials"][7] |= {"status": "timed_out"}
    bundle.write(where / "bots.zip")
    analyze(AnalysisOptions(where / "bots.zip", where / "out", planned_n=30))
    return where
