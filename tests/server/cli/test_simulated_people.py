"""Guards the options about simulated people: wrong mixtures are wrong calls, rates are told."""

from __future__ import annotations

from pathlib import Path

import pytest

from server.cli.learn import describe_rates
from server.cli.main import app, run_command

SIMULATE = ["simulate", "--scale", "practice", "--trials", "1"]
LEARN = ["learn", "--scale", "small", "--iterations", "2"]


def call(words: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a call within this process."""
    code = run_command(lambda **options: app(words, **options))
    said = capsys.readouterr()
    return code, said.out, said.err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([*SIMULATE, "--control", "all_off"], "follows no policy"),
        (
            [*SIMULATE, "--condition", "varil", "--control", "all_off", "--policy", "p.json"],
            "not both",
        ),
        ([*SIMULATE, "--control", "half_off", "--condition", "varil"], "no_ghost"),
        ([*SIMULATE, "--balloon-belief", "always"], "only the believer"),
        ([*LEARN, "--expert", "table", "--wish", "inform"], "wishes and"),
        ([*LEARN, "--view", "below"], "above"),
        ([*LEARN, "--worker", "cyclic", "--balloon-belief", "always"], "only the believer"),
        ([*LEARN, "--classifier", "oracle"], "Use one of: svm"),
        ([*LEARN, "--beta", "falling"], "first_only or exponential(p)"),
        ([*LEARN, "--box-mode", "free"], "--box-mode"),
    ],
)
def test_wrong_mixtures_are_wrong_calls(words, sentence, tmp_path: Path, capsys) -> None:
    code, _, said = call([*words, "--out", str(tmp_path / "out")], capsys)
    assert code == 2
    assert sentence in " ".join(said.replace("│", " ").split())
    assert not (tmp_path / "out").exists()


def test_a_control_runs(tmp_path: Path, capsys) -> None:
    """The control decides the display and is written beside the trials, named as what it is."""
    words = [*SIMULATE, "--condition", "varil", "--control", "no_ghost", "--worker", "believer"]
    code, _, _ = call([*words, "--workers", "1", "--out", str(tmp_path)], capsys)
    assert code == 0
    assert '"name": "no_ghost"' in (tmp_path / "policy.json").read_text()


def test_rates_are_told_beside_what_they_are_held_against(tmp_path: Path, capsys) -> None:
    """Without --json the learned policy stands beside ARROCH, the controls and the floor."""
    code, said, _ = call([*LEARN, "--out", str(tmp_path)], capsys)
    assert code == 0
    for line in ("the policy learned", "ARROCH", "control all_off", "control majority", "floor"):
        assert line in said
    code, said, _ = call([*LEARN, "--json", "--out", str(tmp_path)], capsys)
    assert "ARROCH" not in said


def test_rates_are_those_of_the_last_iterations(tmp_path: Path) -> None:
    """Forty iterations count and no earlier one; rates come from sums, not from mean rates."""
    rows = ["iteration,line,compared,disable,enable,shown", "0,policy,100,100,0,100"]
    rows += [f"{n},policy,{10 if n == 1 else 30},3,1,{5 if n == 1 else 15}" for n in range(1, 41)]
    file = tmp_path / "discrepancies.csv"
    file.write_text("\n".join(rows) + "\n")
    line = describe_rates(file).splitlines()[1]
    assert line.split()[-3:] == ["0.102", "0.136", "0.500"]


def test_a_wrong_call_is_told_before_anything_is_prepared(tmp_path: Path, capsys) -> None:
    """Preparing the compiled world can take minutes, and so can the run; so can a folder that is
    none be told at once."""
    for more, code in ((["--classifier", "oracle"], 2), (["--seed", str(2**54)], 2), ([], 1)):
        taken = tmp_path / "taken"
        taken.write_text("a file\n")
        told, _, said = call([*LEARN, *more, "--out", str(taken)], capsys)
        assert (told, "Preparing" in said) == (code, False), said
        assert taken.read_text() == "a file\n"


def test_a_shorter_run_leaves_no_policy_of_a_longer_one_in_its_folder(
    tmp_path: Path, capsys
) -> None:
    """Else P6 of the former run would be read as the last policy of this one."""
    policies = tmp_path / "policies"
    policies.mkdir()
    for name in ("240.json", "named.json"):
        (policies / name).write_text("{}")
    code, said, _ = call([*LEARN, "--out", str(tmp_path)], capsys)
    assert code == 0
    names = sorted(path.name for path in policies.iterdir())
    assert names == ["000.json", "001.json", "002.json", "named.json"]
    assert "last 2 iterations" in said
