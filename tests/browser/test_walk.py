"""One participant walks the whole study in real Chromium, with real keys and real forms.

From the join link to the completion code; then the exported tables must say what was done.
"""

from __future__ import annotations

import csv
import io
import re
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

from playwright.sync_api import Page, expect

from browser.driver import Driver, read
from study.files.demo import paper_study
from study.warehouse.layout import PRESETS, build_layout

FORBIDDEN = re.compile(r"varil|arroch|crmiar", re.IGNORECASE)
AGE = "34"
FORMULA = "=SUM(A1:A9)"


@dataclass
class Walk:
    """What was done on the way, to be held against the export."""

    page: Page
    answers: dict[str, dict[str, str]] = field(default_factory=dict)
    displays: list[str] = field(default_factory=list)
    unloads: list[int] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    def arrive(self, heading: str | re.Pattern[str]) -> None:
        """Wait for a step's page and keep what it says."""
        expect(self.page.locator("#content h1")).to_contain_text(heading)
        self.texts.append(f"{self.page.title()}\n{self.page.url}\n{self.page.inner_text('body')}")

    def send(self) -> None:
        """Press the page's one button."""
        self.page.locator("main button[type=submit]").click()

    def play(self) -> None:
        """Click into the view, look around with the mouse, and serve the robot."""
        self.page.wait_for_function(
            "() => Number(document.querySelector('#stage')?.dataset.frames) > 0", timeout=90_000
        )
        self.texts.append(f"{self.page.title()}\n{self.page.url}\n{self.page.inner_text('body')}")
        self.page.mouse.click(320, 180)
        self.page.wait_for_function(
            "() => document.querySelector('#stage').dataset.phase === 'running'", timeout=30_000
        )
        driver = Driver(self.page, build_layout(PRESETS["practice"]))
        driver.play(timeout_s=120)
        self.unloads.append(driver.unloads_seen)


def test_a_participant_walks_the_whole_study(page: Page, walk_server, tmp_path: Path) -> None:
    """Join, forms, practice, three trials, code; then the export equals what was done."""
    page.set_default_timeout(60_000)
    foreign = watch_for_foreign_requests(page, walk_server.url)
    walk = Walk(page)
    enter(walk, walk_server.url)
    for position in (1, 2, 3):
        do_round(walk, position)
    code = leave(walk)

    assert foreign == []
    assert [text for text in walk.texts if FORBIDDEN.search(text)] == []
    assert code == paper_study().completion_codes["completed"]
    tables = export_tables(walk_server, tmp_path / "walk.zip")
    check_people(tables, walk)
    check_trials(tables, walk)
    check_answers(tables, walk)
    check_quality(tables)
    for row in tables["trials"]:
        walk_server.varil("replay", row["trial_id"], "--verify")


def enter(walk: Walk, url: str) -> None:
    """From the join link through consent, check, questions and practice."""
    page = walk.page
    page.goto(f"{url}/s/walk?PROLIFIC_PID=abc123")
    walk.arrive(re.compile(r"\w"))
    walk.send()
    expect(page).to_have_url(re.compile(r"/p/[\w-]{20,}$"))
    address = page.url
    for box in page.locator("input[type=checkbox]").all():
        box.check()
    walk.send()
    page.wait_for_function(
        "() => document.querySelector('input[name=latency_ms]')?.value !== ''"
        " && document.querySelector('input[name=frame_rate_hz]')?.value !== ''"
    )
    # The check asks for a key and a mouse movement: real ones.
    page.keyboard.press("w")
    page.mouse.move(100, 100)
    page.mouse.move(220, 160)
    walk.texts.append(page.inner_text("body"))
    walk.send()
    answer(walk, "demographics", {"age": AGE, "gender": "woman", "games_3d": "never"})
    assert page.url.startswith(address)
    walk.send()  # the instructions
    walk.play()


def do_round(walk: Walk, position: int) -> None:
    """Explanation, trial, questionnaire; the second trial is interrupted by a refresh."""
    walk.arrive(re.compile(f"{position} of 3"))
    heading = walk.page.locator("#content h1").inner_text()
    walk.displays.append(heading[-1])
    walk.send()
    if position == 2:
        refresh_in_the_middle(walk)
    walk.play()
    expect(walk.page.locator("fieldset")).to_have_count(6)
    answer(
        walk,
        f"questionnaire-{position}",
        {f"Q{k}": str((k + position) % 5 + 1) for k in range(1, 7)},
    )


def refresh_in_the_middle(walk: Walk) -> None:
    """A refresh must resume the running trial, not start it again."""
    page = walk.page
    page.wait_for_function(
        "() => Number(document.querySelector('#stage')?.dataset.tick) > 60", timeout=90_000
    )
    before = read(page)
    assert before is not None
    page.reload()
    page.wait_for_function("() => document.querySelector('#stage')?.dataset.robots", timeout=90_000)
    after = read(page)
    assert after is not None
    assert after.tick >= before.tick - 1, "the trial began anew"


def answer(walk: Walk, step: str, values: dict[str, str]) -> None:
    """Send a form first with an answer missing, see it refused with nothing lost, then whole."""
    page = walk.page
    walk.arrive(re.compile(r"\w"))
    names = list(values)
    for name in names[1:]:
        fill(page, name, values[name])
    walk.send()
    expect(page.locator("#summary")).to_be_visible()
    for name in names[1:]:
        kept = page.locator(
            f"[name={name}][value='{values[name]}']:checked, input[type=text][name={name}]"
        )
        assert kept.count() == 1, f"{name} was lost"
    fill(page, names[0], values[names[0]])
    for name in unanswered(page):
        fill(page, name, "declined")
        values[name] = "declined"
    walk.answers[step] = values
    walk.send()


def unanswered(page: Page) -> list[str]:
    """Names of radio groups without a choice."""
    return page.evaluate(
        "() => [...new Set([...document.querySelectorAll('input[type=radio]')].map(r => r.name))]"
        ".filter(name => !document.querySelector(`input[name=${name}]:checked`))"
    )


def fill(page: Page, name: str, value: str) -> None:
    """Answer one item as a person would."""
    radio = page.locator(f"input[type=radio][name={name}]")
    if radio.count():
        (
            radio.last if value == "declined" else page.locator(f"[name={name}][value='{value}']")
        ).check()
    else:
        page.locator(f"[name={name}]:not([type=hidden])").first.fill(value)


def leave(walk: Walk) -> str:
    """Comments and debrief; returns the completion code."""
    page = walk.page
    walk.arrive("Anything else")
    page.locator("textarea[name=problems]").fill(FORMULA)
    walk.answers["comments"] = {"problems": FORMULA}
    walk.send()
    code = page.locator("#completion-code")
    expect(code).to_be_visible()
    walk.texts.append(page.inner_text("body"))
    return code.inner_text().strip()


def watch_for_foreign_requests(page: Page, url: str) -> list[str]:
    """Collects every request to another host, and every error of the page's scripts."""
    seen: list[str] = []
    page.on(
        "request",
        lambda r: (
            None
            if r.url.startswith((url, url.replace("http", "ws"), "data:", "blob:"))
            else seen.append(r.url)
        ),
    )
    page.on("pageerror", lambda error: seen.append(str(error)))
    return seen


def export_tables(server, file: Path) -> dict[str, list[dict[str, str]]]:
    """The exported tables by name."""
    server.varil("export", "--study", "walk", "--out", str(file))
    with zipfile.ZipFile(file) as archive:
        return {
            name.removesuffix(".csv"): list(
                csv.DictReader(io.StringIO(archive.read(name).decode()))
            )
            for name in archive.namelist()
            if name.endswith(".csv")
        }


def check_people(tables: dict[str, list[dict[str, str]]], walk: Walk) -> None:
    (participant,) = tables["participants"]
    assert participant["status"] == "completed"
    assert participant["mode"] == "pilot"
    assert participant["participant_code"] not in walk.page.url
    assert "abc123" not in str(tables), "panel ids stay out of research data"
    assert walk.displays == ["A", "B", "C"]


def check_trials(tables: dict[str, list[dict[str, str]]], walk: Walk) -> None:
    trials = sorted(tables["trials"], key=lambda row: int(row["position"]))
    assert [row["position"] for row in trials] == ["1", "2", "3"]
    assert sorted(row["condition"] for row in trials) == ["arroch", "crmiar", "varil"]
    order = tables["participants"][0]["condition_order"]
    assert [row["condition"] for row in trials] == re.findall(r"\w+", order)
    for row in trials:
        assert row["status"] == "completed"
        assert float(row["duration_s"]) > 10
        assert float(row["human_path_m"]) > 1
        assert (row["policy_sha256"] != "") == (row["condition"] == "varil")
    robots = {row["trial_id"]: row for row in tables["robots"]}
    assert set(robots) >= {row["trial_id"] for row in trials}
    assert walk.unloads == [1, 1, 1, 1]
    assert [robots[row["trial_id"]]["boxes_delivered"] for row in trials] == ["1", "1", "1"]
    for row in trials:
        assert abs(float(robots[row["trial_id"]]["wait_s"]) - float(row["sum_wait_s"])) < 1e-6
        assert any(leg["trial_id"] == row["trial_id"] for leg in tables["legs"])


def check_quality(tables: dict[str, list[dict[str, str]]]) -> None:
    """The page's own measurements have reached the tables; a picture in software is slow."""
    assert len(tables["quality"]) == 3
    assert max(int(row["connections"]) for row in tables["quality"]) >= 2  # the refresh
    for row in tables["quality"]:
        assert int(row["reports"]) >= 1
        assert 0 < float(row["rtt_median_ms"]) <= float(row["rtt_p95_ms"])
        assert 0 < float(row["frame_rate_p5_hz"]) <= float(row["frame_rate_median_hz"])
        assert int(row["connections"]) >= 1
        assert 0 <= float(row["hidden_s"]) < 30
        assert float(row["tick_late_p99_ms"]) > 0


def check_answers(tables: dict[str, list[dict[str, str]]], walk: Walk) -> None:
    stored = {(row["step"], row["item"]): row["value"] for row in tables["responses"]}
    for step, values in walk.answers.items():
        for name, value in values.items():
            if value == FORMULA:
                assert stored[step, name] == "'" + FORMULA, (
                    "a formula must not run in a spreadsheet"
                )
            elif value == "declined":
                assert (step, name) in stored
            else:
                assert stored[step, name] == value
