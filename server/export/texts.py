"""The README of an export: what is in it, and how to load it."""

from __future__ import annotations

from collections.abc import Sequence

from server.store.policies import UsedPolicy

ORIGINS = {
    "initial": "initial, taught by nobody",
    "control": "a control, taught by nobody",
    "people": "learned from people",
    "simulated": "learned from simulated people",
}
_README = """Export of the study “{study_id}” ({mode})

One table per file; codebook.csv tells what every column, event and item means, and
datapackage.json describes every table for programs (frictionless validate datapackage.json).
Times are ISO-8601 in UTC; seconds, metres and so on stand in the columns' names (_s, _m).
Tables are joined by participant_code and trial_id.

Files: {files}

- participants.csv has a row for everybody who joined. Of those who withdrew nothing else is given.
- trials.csv has the trials after the practice; analyse those whose status is completed.
- wide.csv has a row per participant, with a column per question and condition.
- flags name exclusion rules of the study that were broken; nothing was deleted because of them.
- Participants whose status is excluded were taken out by staff; status_reason says why.
- notes.csv has what staff wrote about people and about moments of their trials, in their own words.
- Rows whose mode is not live come from pilots or simulated participants.
- In text columns a cell that a spreadsheet would run as a formula begins with an apostrophe.
- MANIFEST.sha256 holds a checksum per file; check with: sha256sum -c MANIFEST.sha256

Loading it in Python (pandas):

  import pandas as pd; from zipfile import ZipFile
  trials = pd.read_csv(ZipFile("{study_id}.zip").open("trials.csv"))

Loading it in R:

  trials <- read.csv(unz("{study_id}.zip", "trials.csv"))

Versions of the study in this export: {versions}

Policies that decided about the display in these trials, by policy_sha256:
{policies}
{failed}"""
_FAILED = """
Trials that could not be re-simulated, so that their telemetry is missing:
{list}
"""


def make_readme(
    study_id: str,
    mode: str | None,
    files: Sequence[str],
    versions: Sequence[str],
    policies: Sequence[UsedPolicy],
    failed: Sequence[str],
) -> str:
    """The text of README.txt; `failed`: trials without telemetry, each with the reason."""
    named = [f"- {used.sha256}: “{used.name}”, {ORIGINS[used.origin]}" for used in policies]
    missing = "\n".join(f"- {line}" for line in failed)
    return _README.format(
        study_id=study_id,
        mode=f"mode {mode} only" if mode else "all modes",
        files=", ".join(files),
        versions=", ".join(versions),
        policies="\n".join(named) or "- none",
        failed=_FAILED.format(list=missing) if missing else "",
    )
