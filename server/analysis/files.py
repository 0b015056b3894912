"""The files of an analysis: report.html, results.json, tables/*.csv, figures/*.svg and *.pdf.

Everything is put together before the first byte is written, and report.html comes last.
"""

from __future__ import annotations

import csv
import importlib.metadata
import io
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from server.analysis.bundle import Bundle
from server.locations import web_root
from study.analysis.report import Report
from study.analysis.sheets import Picture, Sheet
from study.analysis.wording import Cell, capitalise
from study.records.tables import neutralise_formula

REPORT = "report.html"
RESULTS = "results.json"
MADE = (("tables", "csv"), ("figures", "svg"), ("figures", "pdf"))
LIBRARIES = ("varil", "numpy", "scipy", "statsmodels", "matplotlib")


def write_analysis(report: Report, bundle: Bundle, out: Path) -> list[str]:
    """Write all files into the folder, made if need be; returns their names.

    Tables and figures of an earlier analysis there that this one does not make are removed.
    """
    files = make_files(report, bundle)
    if (out / RESULTS).is_file():
        made = (out.glob(f"{folder}/*.{end}") for folder, end in MADE)
        for old in (file for found in made for file in found):
            if old.relative_to(out).as_posix() not in files:
                old.unlink()
    for name, data in files.items():
        path = out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return list(files)


def make_files(report: Report, bundle: Bundle) -> dict[str, bytes]:
    """The bytes of every file by its name below the folder."""
    files: dict[str, bytes] = {}
    for sheet in report.sheets:
        files[table_file(sheet)] = _csv(sheet.header, sheet.rows)
    for picture in report.pictures:
        chart = picture.chart
        files[f"tables/figure_{picture.name}.csv"] = _csv(chart.header, chart.rows)
        files[f"figures/{picture.name}.svg"] = chart.svg
        files[f"figures/{picture.name}.pdf"] = chart.pdf
    files[RESULTS] = _results(report, bundle)
    files[REPORT] = render_report(report, bundle).encode()
    return files


def table_file(sheet: Sheet) -> str:
    """Where a sheet's file lies below the folder."""
    return f"tables/{sheet.name}.csv"


def render_report(report: Report, bundle: Bundle) -> str:
    """The page: one file that loads nothing."""
    templates = Environment(
        loader=FileSystemLoader(web_root() / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    templates.filters["inline_svg"] = inline_svg
    templates.filters["capitalise"] = capitalise
    templates.filters["keep_together"] = keep_together
    templates.tests["picture"] = lambda block: isinstance(block, Picture)
    return templates.get_template("report/report.html").render(
        report=report, bundle=bundle, versions=_versions(), table_file=table_file
    )


def keep_together(sentence: str) -> str:
    """The sentence with spaces that do not break inside `p = 0.012` and `95 %`."""
    return re.sub(
        r" ([=<]) | (?=%)", lambda found: found[0].replace(" ", "\N{NO-BREAK SPACE}"), sentence
    )


def inline_svg(picture: Picture) -> Markup:
    """The figure as part of a page: no prolog, ids of its own, a description for readers."""
    text = picture.chart.svg.decode()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="([^"]+)"', rf'id="{picture.name}-\1"', text)
    text = re.sub(r"url\(#([^)]+)\)", rf"url(#{picture.name}-\1)", text)
    text = re.sub(r'href="#([^"]+)"', rf'href="#{picture.name}-\1"', text)
    label = f'role="img" aria-labelledby="{picture.name}-caption"'
    return Markup(text.replace("<svg", f"<svg {label}", 1))  # noqa: S704 - our own figure


def _csv(header: Sequence[str], rows: Iterable[Sequence[Cell]]) -> bytes:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([_cell(value) for value in row] for row in rows)
    return out.getvalue().encode()


def _cell(value: Cell) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return neutralise_formula(value)
    return repr(value) if isinstance(value, float) else str(value)


def _results(report: Report, bundle: Bundle) -> bytes:
    """Everything as one JSON object, with the rows behind each table."""
    tables = {
        sheet.name: {
            "file": table_file(sheet),
            "rows_behind": sheet.behind.sentence,
            "rows": sheet.records,
        }
        for sheet in report.sheets
    }
    whole: dict[str, Any] = {
        "study_id": report.study_id,
        "mode": report.mode,
        "mark": report.mark,
        "bundle": bundle.name,
        "bundle_sha256": bundle.sha256,
        "conditions": report.conditions,
        "participants": report.joined,
        "excluded": report.excluded,
        "analysed": report.analysed,
        "findings": report.findings,
        "versions": _versions(),
        "tables": tables,
    }
    return (json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _versions() -> Mapping[str, str]:
    return {name: importlib.metadata.version(name) for name in LIBRARIES}
