"""`varil analyze`: from an export's zip to a folder with statistics, figures and a report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from server.analysis.bundle import read_bundle
from server.analysis.files import REPORT, write_analysis
from server.analysis.rows import read_study
from study.analysis.report import build_report


@dataclass(frozen=True)
class AnalysisOptions:
    """What `varil analyze` was asked for."""

    file: Path
    out: Path
    mode: str | None = None
    planned_n: int | None = None
    keep_marked: bool = False


def analyze(options: AnalysisOptions) -> dict[str, Any]:
    """Analyse the zip, write the folder, return the summary.

    Errors: BundleError if the zip cannot be believed; nothing is written then.
    """
    bundle = read_bundle(options.file, options.mode)
    data = read_study(bundle, keep_marked=options.keep_marked)
    report = build_report(data, options.planned_n)
    files = write_analysis(report, bundle, options.out)
    return {
        "report": str(options.out / REPORT),
        "study": report.study_id,
        "mode": report.mode,
        "marked_as": report.mark,
        "conditions": list(report.conditions),
        "participants": report.joined,
        "excluded": report.excluded,
        "analysed": report.analysed,
        "findings": list(report.findings),
        "files": len(files),
    }
