"""Guards study files on disk and the verbs about them: `init`, `validate`, and what is served."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from server.cli.main import app, run_command
from server.policy_files import shipped_policy
from server.settings import Settings
from server.study_files import begin_study, read_study_file, read_study_files
from study.errors import InvalidValue, StudyFileError
from study.files.demo import demo_text, paper_study

POLICY = 'scale = "study"\npolicy = "p.json"'


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A study file that is right."""
    (tmp_path / "study.toml").write_text(demo_text(), encoding="utf-8")
    return tmp_path / "study.toml"


def change(file: Path, old: str, new: str) -> None:
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")


def call(*words: str) -> int:
    return run_command(lambda **options: app(list(words), **options))


def last_line(capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    return dict(json.loads(capsys.readouterr().out.splitlines()[-1]))


def test_a_new_study_is_one_file_and_a_readme_and_valid(tmp_path: Path, capsys) -> None:
    folder = tmp_path / "deep" / "Robots & me"
    assert call("init", str(folder)) == 0
    assert sorted(file.name for file in folder.iterdir()) == ["README.md", "study.toml"]
    study = read_study_file(folder / "study.toml").study
    assert study.study_id == "robots-me"
    assert "/s/robots-me" in (folder / "README.md").read_text(encoding="utf-8")
    assert study.conditions == paper_study().conditions
    assert study.recruiting == "pilot"
    capsys.readouterr()
    assert call("validate", str(folder / "study.toml"), "--json") == 0
    assert last_line(capsys) == {"valid": True, "errors": []}


def test_the_codes_of_a_new_study_are_its_own(tmp_path: Path) -> None:
    """Codes that stand in a public repository could be guessed."""
    codes = [set(paper_study().completion_codes.values())]
    for name in ("a", "b"):
        begin_study(tmp_path / name)
        codes.append(
            set(read_study_file(tmp_path / name / "study.toml").study.completion_codes.values())
        )
    assert len(set.union(*codes)) == 3 * len(codes[0])


@pytest.mark.parametrize("name", ["varil-2", "123", "Ünï"])
def test_a_folder_whose_name_cannot_be_a_study_id_gets_another(tmp_path: Path, name: str) -> None:
    begin_study(tmp_path / name)
    assert read_study_file(tmp_path / name / "study.toml").study.study_id in ("my-study", "n")


def test_a_folder_that_holds_something_is_left_alone(tmp_path: Path, capsys) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert call("init", str(tmp_path)) == 1
    assert call("init", str(tmp_path / "notes.txt")) == 1
    said = capsys.readouterr().err
    assert "is not empty" in said
    assert "is no folder" in said
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]


def test_every_mistake_is_told_with_path_value_and_message(file: Path, capsys) -> None:
    change(file, "tries = 3", "tries = 99")
    change(file, "seed = 20221214", "sede = 20221214")
    assert call("validate", str(file), "--json") == 1
    told = last_line(capsys)
    assert told["valid"] is False
    assert told["errors"] == [
        {
            "path": "seed",
            "value": None,
            "message": "this key is missing; give a whole number from 0 to 9007199254740991",
        },
        {
            "path": "practice.tries",
            "value": 99,
            "message": "not allowed here; give a whole number from 1 to 20",
        },
        {
            "path": "sede",
            "value": 20221214,
            "message": "there is no such key; did you mean `seed`?",
        },
    ]
    assert call("validate", str(file)) == 1
    said = capsys.readouterr().err
    assert "practice.tries = 99: not allowed here; give a whole number from 1 to 20." in said
    assert "3 mistakes" in said


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00", b"#" * 5_000_000])
def test_a_file_that_cannot_be_read_is_told_the_same_way(
    file: Path, capsys, content: bytes | None
) -> None:
    if content is None:
        file.unlink()
    else:
        file.write_bytes(content)
    assert call("validate", str(file), "--json") == 1
    assert [entry["path"] for entry in last_line(capsys)["errors"]] == [""]


def test_serving_a_wrong_file_lists_its_mistakes_and_starts_nothing(
    file: Path, capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VARIL_VAR_DIR", str(file.parent / "var"))
    change(file, "tries = 3", "tries = 99")
    assert call("serve", "--study", str(file)) == 1
    assert "practice.tries = 99" in capsys.readouterr().err
    assert not (file.parent / "var").exists()


def test_without_a_file_the_demo_is_served(monkeypatch: pytest.MonkeyPatch, file: Path) -> None:
    assert [one.study for one in read_study_files(())] == [paper_study()]
    monkeypatch.setenv("VARIL_STUDY_FILES", json.dumps([str(file)]))
    assert Settings().study_files == (file,)
    assert read_study_files(Settings().study_files)[0].study == paper_study()


def test_two_files_of_one_study_are_refused(file: Path) -> None:
    with pytest.raises(InvalidValue, match="both have the study_id “demo”"):
        read_study_files([file, file])


def test_a_studys_policy_is_frozen_with_it(file: Path) -> None:
    policy = shipped_policy()
    (file.parent / "p.json").write_text(policy.to_json(), encoding="utf-8")
    change(file, 'scale = "study"', POLICY)
    read = read_study_file(file)
    assert read.policy == policy
    assert read.study.policy_sha256 == policy.sha256
    assert read.study.config_hash != paper_study().config_hash


@pytest.mark.parametrize(
    ("write", "further", "place", "sentence"),
    [
        (False, "", "policy", "cannot be read"),
        (True, f'\npolicy_sha256 = "{"0" * 64}"', "policy_sha256", "has another hash"),
    ],
)
def test_a_policy_that_does_not_fit_is_named(
    file: Path, write: bool, further: str, place: str, sentence: str
) -> None:
    if write:
        (file.parent / "p.json").write_text(shipped_policy().to_json(), encoding="utf-8")
    change(file, 'scale = "study"', POLICY + further)
    with pytest.raises(StudyFileError) as caught:
        read_study_file(file)
    (problem,) = caught.value.problems
    assert problem.place == (place,)
    assert sentence in problem.message


def test_a_policy_for_other_thresholds_is_named(file: Path) -> None:
    (file.parent / "p.json").write_text(shipped_policy().to_json(), encoding="utf-8")
    change(file, 'scale = "study"', POLICY)
    change(file, "far_m = 15.0", "far_m = 16.0")
    with pytest.raises(StudyFileError) as caught:
        read_study_file(file)
    assert "far_m" in caught.value.problems[0].message


def test_a_hash_without_its_file_is_refused(file: Path) -> None:
    change(file, 'scale = "study"', f'scale = "study"\npolicy_sha256 = "{"0" * 64}"')
    with pytest.raises(StudyFileError) as caught:
        read_study_file(file)
    assert "name the policy's file" in caught.value.problems[0].message
