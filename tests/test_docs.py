"""Guards the documentation: what it names exists, and what exists is named."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from server.cli.main import app, user
from server.settings import Settings
from study.records.tables import TABLES
from study.warehouse.layout import PRESETS

ROOT = Path(__file__).parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])


@pytest.mark.parametrize("document", PAGES, ids=lambda path: path.name)
def test_links_and_pictures_lead_somewhere(document: Path) -> None:
    """A renamed file must not leave a dead link behind."""
    targets = re.findall(r"\]\(([^)#\s]+)", document.read_text())
    local = [target for target in targets if "://" not in target]
    assert [target for target in local if not (document.parent / target).exists()] == []


def test_the_readme_is_short_and_names_the_two_commands() -> None:
    text = (ROOT / "README.md").read_text()
    assert text.count("\n") < 120
    assert "make run" in text
    assert "make test" in text


def test_every_column_of_the_export_is_described() -> None:
    """docs/data.md lists each table's columns in the table's own order."""
    text = (ROOT / "docs/data.md").read_text()
    for table in TABLES.values():
        section = text.split(f"## {table.file}\n")[1].split("\n## ")[0]
        assert re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE) == table.header


def test_every_setting_is_described() -> None:
    text = (ROOT / "docs/running.md").read_text()
    assert [name for name in Settings.model_fields if f"VARIL_{name.upper()}" not in text] == []


def test_the_halls_are_described_as_they_are() -> None:
    """Robots, boxes and caps in the table of docs/experiment.md are those of the presets."""
    text = (ROOT / "docs/experiment.md").read_text()
    for name, spec in PRESETS.items():
        (row,) = re.findall(rf"^\| `{name}` \|(.*)\|$", text, re.MULTILINE)
        shelves, robots, boxes, _, cap, _ = (
            re.sub(r"\[.*?\]", "", cell).strip() for cell in row.split("|")
        )
        assert shelves.startswith(f"{spec.shelf_columns} x {spec.shelf_rows}")
        assert (int(robots), int(boxes), float(cap)) == (
            spec.robots,
            spec.boxes_per_robot,
            spec.cap_s,
        )


def test_commands_in_the_documentation_exist() -> None:
    """Every `varil VERB` that a page shows is a verb of the command."""
    verbs = {info.name or info.callback.__name__ for info in app.registered_commands}
    verbs |= {group.name for group in app.registered_groups}
    shown = {
        verb
        for page in PAGES
        for verb in re.findall(r"(?:^|[`/ ])varil ([a-z]+)", page.read_text(), re.MULTILINE)
    }
    assert {"serve", "simulate", "export"} <= shown
    assert shown - verbs == set()
    assert {info.name for info in user.registered_commands} == {"add"}
