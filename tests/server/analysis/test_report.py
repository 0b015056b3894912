"""Guards the report as a page: one file, marked throughout, the same bytes each time."""

from __future__ import annotations

import html.parser
import json
from pathlib import Path

import pytest

from server.analysis.run import AnalysisOptions, analyze
from server.cli.main import app, run_command
from tests.server.analysis.bundles import analyse_bots, make_bundle


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """24 bots, of whom one is excluded and one lost a trial."""
    return analyse_bots(tmp_path_factory.mktemp("analysis"))


class Page(html.parser.HTMLParser):
    """Collects what a page would load, its ids and what it points to."""

    def __init__(self) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.figures = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self.figures += tag == "figure"
        if tag in {"script", "link", "img", "iframe", "object"} or found.get("src"):
            self.loads.append(tag)
        if found.get("id"):
            self.ids.append(str(found["id"]))
        for name in ("href", "xlink:href"):
            if found.get(name):
                self.links.append(str(found[name]))


def read_page(out: Path) -> tuple[str, Page]:
    text = (out / "report.html").read_text()
    page = Page()
    page.feed(text)
    return text, page


def test_the_report_is_one_file_that_loads_nothing(folder: Path) -> None:
    """No script, picture or sheet from elsewhere; ids are unique; links lead to written files."""
    out = folder / "out"
    text, page = read_page(out)
    assert page.loads == []
    assert "@import" not in text
    assert len(page.ids) == len(set(page.ids))
    for link in page.links:
        assert link[1:] in page.ids if link[0] == "#" else (out / link).is_file(), link
    assert page.figures == 5


def test_simulated_data_are_marked_everywhere(folder: Path) -> None:
    """On the page's top, every section, every printed page and every figure, also in its files."""
    text, page = read_page(folder / "out")
    assert text.count('<span class="tag">simulated participants (bots)</span>') == 8
    assert '@top-center { content: "Simulated participants (bots)"' in text
    figures = list((folder / "out/figures").glob("*.svg"))
    assert len(figures) == page.figures
    assert all("simulated participants (bots)" in figure.read_text() for figure in figures)
    assert all(path.with_suffix(".pdf").read_bytes()[:5] == b"%PDF-" for path in figures)


def test_live_data_carry_no_mark(tmp_path: Path) -> None:
    path = make_bundle(2, mode="live").write(tmp_path / "a.zip")
    assert analyze(AnalysisOptions(path, tmp_path / "out"))["marked_as"] == ""
    text, _ = read_page(tmp_path / "out")
    assert "simulated" not in text
    assert 'class="mark"' not in text


def test_the_same_bundle_gives_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    analyze(AnalysisOptions(folder / "bots.zip", tmp_path, planned_n=30))
    for path in (folder / "out").rglob("*.*"):
        assert (tmp_path / path.relative_to(folder / "out")).read_bytes() == path.read_bytes()


def test_words_from_the_bundle_are_words_in_the_page(tmp_path: Path) -> None:
    """Wordings are text: no markup, no formula of the drawing library, no path of the system."""
    bundle = make_bundle(4)
    for row in bundle.tables["codebook"]:
        if row["name"] == "questionnaire.Q1":
            row |= {"meaning": "<script>alert(1)</script>", "levels": "1=$a$|2=^_{$|3=c|4=d|5=e"}
        if row["name"].startswith("questionnaire."):
            row["name"] = row["name"].replace("questionnaire.", "../../up.")
    for row in bundle.tables["responses"]:
        row["instrument"] = row["instrument"].replace("questionnaire", "../../up")
    for row in bundle.tables["trials"]:
        row["condition"] = row["condition"].replace("arroch", "<b>&$^_{$")
    analyze(AnalysisOptions(bundle.write(tmp_path / "a.zip"), tmp_path / "out"))
    text, _ = read_page(tmp_path / "out")
    assert "<script>alert" not in text
    assert "<b>" not in text
    assert {path.name for path in tmp_path.iterdir()} == {"a.zip", "out"}


def test_an_earlier_analysis_leaves_nothing_behind(tmp_path: Path) -> None:
    """Figures of yesterday's data must not lie beside today's report."""
    out = tmp_path / "out"
    analyze(AnalysisOptions(make_bundle(1).write(tmp_path / "a.zip"), out))
    (out / "figures/mine.txt").write_text("kept")
    analyze(AnalysisOptions(make_bundle(0).write(tmp_path / "b.zip"), out))
    assert [path.name for path in (out / "figures").iterdir()] == ["mine.txt"]


def test_the_command_tells_one_json_line(
    folder: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    words = ["varil", "analyze", str(folder / "bots.zip"), "--out", str(tmp_path), "--json"]
    monkeypatch.setattr("sys.argv", words)
    assert run_command(app) == 0
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (told["mode"], told["analysed"]) == ("bot", 22)
    assert Path(told["report"]).is_file()
    monkeypatch.setattr("sys.argv", [*words[:2], str(tmp_path / "none.zip"), *words[3:]])
    assert run_command(app) == 1
    assert "none.zip" in capsys.readouterr().err
