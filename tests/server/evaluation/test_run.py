"""Guards `varil evaluate`: figures and tables of real output, and a clear word for bad input."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from server.cli.main import app, run_command
from server.evaluation.run import BOOTSTRAP_SEED, evaluate
from server.headless.learning import LearningOptions, learn
from server.headless.trials import SimulationOptions, run_simulation
from study.analysis.intervals import bootstrap_paired
from study.errors import InvalidValue, PolicyError
from study.learning.settings import LearningSettings

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two learning runs and trials under their policies, two displays and one other worker."""
    folder = tmp_path_factory.mktemp("output")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VARIL_CACHE_DIR", str(ROOT / "var" / "kernels"))
        for seed in (1, 2):
            settings = LearningSettings(iterations=6, seed=seed)
            learn(LearningOptions(folder / f"learn-{seed}", settings, "practice", quiet=True))
            policy = folder / f"learn-{seed}" / "policies" / "006.json"
            simulate(folder / f"varil-{seed}", "varil", policy=policy)
        simulate(folder / "initial", "varil", policy=folder / "learn-1" / "policies" / "000.json")
        simulate(folder / "arroch", "arroch")
        simulate(folder / "none", "none", trials=12)
        simulate(folder / "cyclic", "none", worker="cyclic")
    return folder


@pytest.fixture(scope="module")
def evaluated(output: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    """All of it evaluated once: the folder and the summary."""
    out = tmp_path_factory.mktemp("evaluated")
    return out, evaluate([output], out)


def simulate(out: Path, condition: str, **more: object) -> None:
    given = {"worker": "believer", "trials": 10, "seed": 5, "scale": "practice", "quiet": True}
    run_simulation(SimulationOptions(out, condition, **given | more))  # type: ignore[arg-type]


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_figures_and_tables_of_real_output(evaluated: tuple[Path, dict]) -> None:
    out, summary = evaluated
    assert summary["learning_runs"] == 2
    assert summary["groups"] == [
        "P1", "after 6 iterations", "arroch", "none", "cyclic worker",
    ]  # fmt: skip
    assert summary["figures"] == [
        "discrepancies", "waits-conditions", "waits-differences", "waits-policies",
    ]  # fmt: skip
    for name in summary["figures"]:
        assert b"simulated people" in (out / f"{name}.svg").read_bytes()
        assert (out / f"{name}.pdf").read_bytes().startswith(b"%PDF-")
        assert rows_of(out / f"{name}.csv")
    assert "none and arroch: 2 seeds without a partner were left out." in summary["notes"]
    assert "simulated people" in (out / "notes.txt").read_text()


def test_numbers_are_those_of_the_trials(output: Path, evaluated: tuple[Path, dict]) -> None:
    """Recomputed from the tables that `simulate` wrote, apart from the code under test."""
    found, _ = evaluated

    def waits(name: str) -> list[float]:
        rows = sorted(rows_of(output / name / "trials.csv"), key=lambda row: int(row["seed"]))
        return [float(row["sum_wait_s"]) for row in rows[:10]]

    rows = {(r["measure"], r["ours"], r["theirs"]): r for r in rows_of(found / "differences.csv")}
    learned = rows["sum_wait_s", "after 6 iterations", "arroch"]
    runs = np.array([waits("varil-1"), waits("varil-2")])
    assert float(learned["difference"]) == pytest.approx(
        np.mean(runs) - np.mean(waits("arroch")), abs=1e-4
    )
    assert float(learned["shorter_share"]) == pytest.approx(
        np.mean(runs < waits("arroch")), abs=1e-4
    )
    assert (learned["runs"], learned["seeds"], learned["left_out"]) == ("2", "10", "0")
    static = rows["sum_wait_s", "none", "arroch"]
    near = bootstrap_paired(waits("none"), waits("arroch"), BOOTSTRAP_SEED)
    assert float(static["difference"]) == pytest.approx(near.mean, abs=1e-4)
    assert float(static["low"]) == pytest.approx(near.low, abs=0.25 * (near.high - near.low))
    curve = [r for r in rows_of(found / "discrepancies.csv") if r["measure"] == "disable"]
    seen = [
        [
            int(r["disable"])
            for r in rows_of(output / f"learn-{seed}" / "discrepancies.csv")
            if r["line"] == "policy"
        ]
        for seed in (1, 2)
    ]
    assert [float(r["mean"]) for r in curve if r["line"] == "policy"] == np.mean(
        seen, axis=0
    ).tolist()


def test_the_same_output_gives_the_same_bytes(
    output: Path, evaluated: tuple[Path, dict], tmp_path: Path
) -> None:
    before, _ = evaluated
    evaluate([output], tmp_path)
    for file in before.iterdir():
        assert file.read_bytes() == (tmp_path / file.name).read_bytes(), file.name


def test_one_run_has_no_band_and_says_so(output: Path, tmp_path: Path) -> None:
    summary = evaluate([output / "learn-1"], tmp_path)
    assert summary["figures"] == ["discrepancies"]
    assert summary["notes"] == ["Learning runs: one run only, so there is no band."]


def test_the_verb_tells_a_summary(output: Path, tmp_path: Path, capsys) -> None:
    words = [
        "evaluate",
        str(output / "arroch"),
        str(output / "none"),
        "--out",
        str(tmp_path),
        "--json",
    ]
    assert run_command(lambda **options: app(words, **options)) == 0
    summary = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (summary["trials"], summary["people"]) == (22, "simulated")


def lose_column(folder: Path) -> None:
    path = folder / "arroch" / "trials.csv"
    path.write_text(path.read_text().replace("sum_wait_s", "wait"))


def lose_rows(folder: Path) -> None:
    path = folder / "arroch" / "trials.csv"
    path.write_text(path.read_text().splitlines()[0] + "\n")


def cut_off(folder: Path) -> None:
    path = folder / "arroch" / "trials.csv"
    path.write_text(path.read_text()[:-60])


def write_words(folder: Path) -> None:
    path = folder / "arroch" / "trials.csv"
    path.write_text(path.read_text().replace(",completed,", ",crashed,", 1))


def write_no_number(folder: Path) -> None:
    path = folder / "learn-1" / "discrepancies.csv"
    lines = path.read_text().splitlines()
    cells = lines[1].split(",")
    cells[3] = "nan"
    path.write_text("\n".join([lines[0], ",".join(cells), *lines[2:]]))


def lose_iteration(folder: Path) -> None:
    path = folder / "learn-1" / "discrepancies.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:3], *lines[4:]]))


def lose_policies(folder: Path) -> None:
    shutil.rmtree(folder / "learn-1" / "policies")


def swap_policy(folder: Path) -> None:
    shutil.copy(folder / "initial" / "policy.json", folder / "varil-1" / "policy.json")


def pretend_people(folder: Path) -> None:
    path = folder / "arroch" / "trials.csv"
    path.write_text(path.read_text().replace(",bot,", ",live,"))


def mix_scales(folder: Path) -> None:
    path = folder / "arroch" / "trials.csv"
    path.write_text(path.read_text().replace(",practice,", ",lab,"))


def mix_settings(folder: Path) -> None:
    path = folder / "arroch" / "trials.csv"
    config = rows_of(path)[0]["config_hash"]
    path.write_text(path.read_text().replace(config, "0" * 64))


def repeat_otherwise(folder: Path) -> None:
    shutil.copytree(folder / "arroch", folder / "again")
    path = folder / "again" / "trials.csv"
    rows = rows_of(path)
    path.write_text(path.read_text().replace(f",{rows[0]['sum_wait_s']},", ",1.0,", 1))


def empty_all(folder: Path) -> None:
    shutil.rmtree(folder)
    folder.mkdir()


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lose_column, r"trials.csv: the table lacks sum_wait_s"),
        (lose_rows, r"trials.csv: the table has no rows"),
        (cut_off, r"line 11: the row has another number of cells"),
        (write_words, r"line 2: status is “crashed”.*Allowed here: completed, timed_out"),
        (write_no_number, r"discrepancies.csv, line 2: disable is “nan”, wanted a number"),
        (lose_iteration, r"iteration 3 of “policy” stands where 2 was expected"),
        (lose_policies, r"there is no learned policy in it.*varil learn"),
        (swap_policy, r"the trials ran with the policy .* the file holds"),
        (pretend_people, r"do not come from `varil simulate`.*varil analyze"),
        (mix_scales, r"differ in their scales: lab \(.*arroch\), practice"),
        (mix_settings, r"differ in their settings of hall or people"),
        (repeat_otherwise, r"seed 5 was run twice with two different results"),
        (empty_all, r"holds neither discrepancies.csv nor trials.csv"),
    ],
)
def test_bad_input_is_named_and_writes_nothing(
    damage: Callable[[Path], None], sentence: str, output: Path, tmp_path: Path
) -> None:
    shutil.copytree(output, tmp_path / "in")
    damage(tmp_path / "in")
    with pytest.raises((InvalidValue, PolicyError), match=sentence):
        evaluate([tmp_path / "in"], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_place_that_is_no_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match=r"nowhere: there is no such folder"):
        evaluate([tmp_path / "nowhere"], tmp_path / "out")


def test_groups_without_a_common_seed_are_not_compared(output: Path, tmp_path: Path) -> None:
    shutil.copytree(output / "none", tmp_path / "none")
    path = tmp_path / "none" / "trials.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], *lines[-2:]]))
    summary = evaluate([output / "arroch", tmp_path / "none"], tmp_path / "out")
    assert "none and arroch have no seed in common: not compared." in summary["notes"]
    assert summary["tables"] == ["groups"]
