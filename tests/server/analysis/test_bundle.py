"""Guards what an analysis believes: a damaged, changed or mixed-up export is refused by name."""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from server.analysis.bundle import BundleError, read_bundle
from server.analysis.rows import read_study
from server.analysis.run import AnalysisOptions, analyze
from study.analysis.cases import correction_family, item_design, team_design
from tests.server.analysis.bundles import Bundle, make_bundle

Change = Callable[[Bundle], None]


def set_cell(table: str, column: str, value: str, row: int = 0) -> Change:
    def change(bundle: Bundle) -> None:
        bundle.tables[table][row][column] = value

    return change


def drop_column(table: str, column: str) -> Change:
    def change(bundle: Bundle) -> None:
        bundle.headers[table] = [name for name in bundle.headers[table] if name != column]

    return change


def drop_table(table: str) -> Change:
    def change(bundle: Bundle) -> None:
        del bundle.headers[table]

    return change


def repeat_person(bundle: Bundle) -> None:
    bundle.tables["participants"].append(bundle.tables["participants"][0])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (drop_table("trials"), "the zip has no trials.csv"),
        (drop_table("codebook"), "the zip has no codebook.csv"),
        (drop_column("trials", "sum_wait_s"), "trials.csv: the column sum_wait_s is missing"),
        (drop_column("participants", "mode"), "participants.csv: the column mode is missing"),
        (set_cell("trials", "sum_wait_s", "fast"), "row 1 of mode bot: sum_wait_s is “fast”"),
        (set_cell("trials", "slowest_robot_s", "nan", 1), "row 2 .* slowest_robot_s is “nan”"),
        (set_cell("trials", "sum_wait_s", "-1"), "sum_wait_s is “-1”, and no number of seconds"),
        (set_cell("trials", "position", "0"), "position is “0”, and no whole number from 1"),
        (set_cell("trials", "condition", ""), "the trial has no condition"),
        (set_cell("trials", "participant_code", "X"), "participant “X” has no row in participants"),
        (set_cell("responses", "participant_code", "X"), "responses.csv, .* “X” has no row"),
        (set_cell("participants", "mode", "robot"), "the mode “robot” is not known"),
        (set_cell("participants", "study_id", "other"), "more than one study"),
        (
            set_cell("participants", "participant_code", ""),
            "code “” stands in 1 row",
        ),
        (repeat_person, "code “P0000” stands in 2 rows"),
    ],
)
def test_bad_exports_are_refused_by_name(change: Change, sentence: str, tmp_path: Path) -> None:
    """The sentence names the file and what is wrong in it, and nothing is written."""
    bundle = make_bundle(3)
    change(bundle)
    path = bundle.write(tmp_path / "bad.zip")
    with pytest.raises(BundleError, match=sentence):
        analyze(AnalysisOptions(path, tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_a_changed_file_is_refused(tmp_path: Path) -> None:
    """A checksum that does not hold names its file; so does one that is missing."""
    bundle = make_bundle(2)
    path = bundle.write(tmp_path / "a.zip", lies={"responses": "0" * 64})
    with pytest.raises(BundleError, match=r"responses\.csv is not the file that MANIFEST"):
        read_bundle(path)
    path = bundle.write(tmp_path / "b.zip")
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("wide.csv", "participant_code\nP0000\n")
    with pytest.raises(BundleError, match=r"wide\.csv is not the file that MANIFEST"):
        read_bundle(path)


def test_what_is_no_zip_is_refused(tmp_path: Path) -> None:
    """Text, a zip cut short, a zip without a manifest, a damaged one; a folder is the system's."""
    whole = make_bundle(2).write(tmp_path / "whole.zip").read_bytes()
    (tmp_path / "text.zip").write_text("participant_code,mode\n")
    (tmp_path / "short.zip").write_bytes(whole[: len(whole) // 2])
    damaged = bytearray(whole)
    damaged[200:240] = bytes(40)
    (tmp_path / "damaged.zip").write_bytes(damaged)
    for name in ("text.zip", "short.zip", "damaged.zip"):
        with pytest.raises(BundleError, match="not a complete zip"):
            read_bundle(tmp_path / name)
    with zipfile.ZipFile(tmp_path / "bare.zip", "w") as archive:
        archive.writestr("trials.csv", "")
    with pytest.raises(BundleError, match=r"the zip has no MANIFEST\.sha256"):
        read_bundle(tmp_path / "bare.zip")
    with pytest.raises(OSError):
        read_bundle(tmp_path)


def test_a_manifest_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("MANIFEST.sha256", "hello\n")
        for name in ("participants", "trials", "responses", "codebook"):
            archive.writestr(f"{name}.csv", "")
    with pytest.raises(BundleError, match="a line that is no checksum"):
        read_bundle(path)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b"", r"trials\.csv: the columns participant_code, mode, .* are missing"),
        (b"participant_code\n\xff\xfe", r"trials\.csv: this is no table in UTF-8"),
        (b'"participant_code', r"trials\.csv: this is no table in UTF-8"),
        (b"%s\nP0000,bot\n", r"trials\.csv: row 2 has 2 cells and the header has 20"),
    ],
)
def test_tables_that_are_none_are_refused(data: bytes, sentence: str, tmp_path: Path) -> None:
    """Empty, of another encoding, cut short, or saved with fewer cells."""
    bundle = make_bundle(1)
    header = ",".join(bundle.headers["trials"]).encode()
    data = data.replace(b"%s", header)
    whole = bundle.write(tmp_path / "whole.zip")
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(whole) as source, zipfile.ZipFile(path, "w") as archive:
        for name in source.namelist():
            if name not in {"trials.csv", "MANIFEST.sha256"}:
                archive.writestr(name, source.read(name))
        lines = source.read("MANIFEST.sha256").decode().splitlines(keepends=True)
        kept = [line for line in lines if "trials.csv" not in line]
        archive.writestr("trials.csv", data)
        kept.append(f"{hashlib.sha256(data).hexdigest()}  trials.csv\n")
        archive.writestr("MANIFEST.sha256", "".join(kept))
    with pytest.raises(BundleError, match=sentence):
        read_bundle(path)


def test_modes_are_never_mixed(tmp_path: Path) -> None:
    """Live if there are any, else the only mode, else the caller chooses."""
    bots, pilots, live = (make_bundle(2, mode=mode) for mode in ("bot", "pilot", "live"))
    both = Bundle(dict(bots.tables), bots.headers)
    for name in ("participants", "trials", "responses"):
        more = [
            row | {"participant_code": "X" + row["participant_code"]} for row in pilots.tables[name]
        ]
        both.tables[name] = bots.tables[name] + more
    path = both.write(tmp_path / "both.zip")
    with pytest.raises(BundleError, match=r"pilot \(2 participants\), bot \(2 participants\)"):
        read_bundle(path)
    assert read_bundle(path, "bot").mode == "bot"
    chosen = read_bundle(path, "pilot")
    assert {row["mode"] for row in chosen.rows["trials.csv"]} == {"pilot"}
    assert chosen.others == {"bot": 2}
    with pytest.raises(BundleError, match="no participants of mode live"):
        read_bundle(path, "live")
    assert read_bundle(live.write(tmp_path / "live.zip")).mode == "live"
    assert read_bundle(bots.write(tmp_path / "bots.zip")).mode == "bot"


def test_whom_staff_excluded_and_what_rules_mark_is_left_out(tmp_path: Path) -> None:
    """A status, a rule about a person, a rule about a trial; marks alone can be kept."""
    bundle = make_bundle(5)
    people = bundle.tables["participants"]
    people[0] |= {"status": "excluded", "status_reason": "said so"}
    people[1] |= {"status": "excluded"}
    people[2] |= {"flags": "looked_away|slow"}
    trial = dict.fromkeys(bundle.headers["quality"], "")
    trial |= {"participant_code": "P0003", "mode": "bot", "position": "2", "flags": "looked_away"}
    bundle.tables["quality"].append(trial)
    bundle.tables["quality"].append(trial | {"position": "3", "flags": ""})
    read = read_bundle(bundle.write(tmp_path / "a.zip"))
    data = read_study(read)
    assert [person.excluded for person in data.people] == [
        "said so",
        "no reason given",
        "marked by looked_away, slow",
        "",
        "",
    ]
    assert (data.marked_people, data.marked_trials) == (1, 1)
    design = team_design(data, "sum_wait_s")
    assert design.participants == ("P0004",)
    assert "trial 2 marked by looked_away" in design.left_out[0].reason
    assert item_design(data, data.rated_items[0]).participants == ("P0004",)
    kept = read_study(read, keep_marked=True)
    assert team_design(kept, "sum_wait_s").participants == ("P0002", "P0003", "P0004")


def test_scores_are_read_beside_the_items(tmp_path: Path) -> None:
    """The score of an instrument after each trial stands in wide.csv alone."""
    bundle = make_bundle(3)
    columns = [f"questionnaire_score_{name}" for name in ("varil", "arroch", "crmiar")]
    bundle.headers["wide"] = ["participant_code", "mode", *columns]
    bundle.tables["wide"] = [
        {"participant_code": f"P{k:04}", "mode": "bot"} | dict.fromkeys(columns, str(10 * k))
        for k in range(3)
    ]
    data = read_study(read_bundle(bundle.write(tmp_path / "a.zip")))
    score = data.rated_items[-1]
    assert (score.instrument, score.kind) == ("questionnaire", "score")
    assert item_design(data, score).values[:, 0].tolist() == [0.0, 10.0, 20.0]
    assert correction_family(data.rated_items, "questionnaire") == tuple(
        f"Q{k}" for k in range(2, 7)
    )
