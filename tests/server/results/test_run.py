"""Guards `make results`: what is planned, nothing run twice, and every outcome worded."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import pytest
from rich.console import Console

from server.headless.backends import Backend
from server.results import pieces as results_pieces
from server.results import plan as results_plan
from server.results import run as results
from server.results.pieces import PieceWork, Store, describe_piece
from server.results.plan import (
    SIZES,
    choose_size,
    main_ways,
    plan_learning,
    plan_trials,
    points,
    side_ways,
)
from server.results.run import make_results
from server.results.words import FALLS, LEFT, SHORTER, signed
from study.analysis.claims import Verdict
from study.errors import InvalidValue
from study.people.sensitivity import STRONGEST

ROOT = Path(__file__).parents[3]
FULL, TINY = SIZES["full"], SIZES["tiny"]


@pytest.fixture(autouse=True)
def _kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VARIL_CACHE_DIR", str(ROOT / "var" / "kernels"))


def test_the_plan_holds_what_was_asked_for() -> None:
    """10 runs for each box mode, P1 to P6 on 250 common seeds, controls, six parameters twice."""
    learning, trials = plan_learning(FULL), plan_trials(FULL)
    assert points(FULL) == (0, 50, 100, 150, 200, 240)
    for way in main_ways(FULL):
        seeds = [piece.seed for piece in learning if piece.way == way and not piece.change]
        assert len(set(seeds)) == 10
        for number in range(2, 7):
            mine = [piece for piece in trials if piece.group == f"P{number} {way.name}"]
            mine = [piece for piece in mine if not piece.change]
            assert {(piece.trials, piece.first_seed) for piece in mine} == {(250, 20_000)}
            assert len(mine) == (10 if number == 6 else 5)
    fixed = {piece.group for piece in trials if piece.learned is None and not piece.change}
    assert fixed == {
        "arroch", "crmiar", "none", "full", "all_off", "no_ghost", "oracle worker", "cyclic worker",
    }  # fmt: skip
    names = {way.name.split(": ")[1] for way in side_ways(FULL)}
    assert names == {
        "declutter, above", "inform, worker", "inform, above", "majority", "per_element",
        "snapshot",
    }  # fmt: skip
    changed = {piece.change for piece in learning if piece.change}
    assert changed == {f"{what}, {word}" for what in STRONGEST for word in ("halved", "doubled")}


def test_no_two_pieces_are_one_and_no_two_sizes_share_seeds() -> None:
    for size in SIZES.values():
        pieces = [*plan_learning(size), *plan_trials(size)]
        assert len({repr(describe_piece(piece)) for piece in pieces}) == len(pieces)
    ranges = [
        range(first, first + count)
        for size in SIZES.values()
        for first, count in ((size.first_seed, size.trials), (size.first_run, size.runs))
    ]
    assert sum(len(each) for each in ranges) == len({seed for each in ranges for seed in each})
    with pytest.raises(InvalidValue, match="full, small, tiny"):
        choose_size("huge")


def test_a_piece_runs_once_and_again_only_for_other_code(tmp_path: Path) -> None:
    piece = plan_learning(TINY)[0]
    store = Store(tmp_path, "code")
    place = PieceWork(store, points(TINY))(piece)
    names = sorted(file.name for file in (place / "policies").iterdir())
    assert names == [f"{step:03}.json" for step in points(TINY)]
    (place / "mark").touch()
    assert PieceWork(store, points(TINY))(piece) == place
    assert (place / "mark").exists()
    other = PieceWork(Store(tmp_path, "other code"), points(TINY))(piece)
    assert other != place
    for file in ("discrepancies.csv", "policies/012.json"):
        assert (other / file).read_bytes() == (place / file).read_bytes()


def test_a_piece_that_breaks_leaves_no_finished_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*what: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(results_pieces, "write_discrepancies", fail)
    piece, store = plan_learning(TINY)[0], Store(tmp_path, "code")
    with pytest.raises(KeyboardInterrupt):
        PieceWork(store, points(TINY))(piece)
    assert not store.place(piece).exists()


def test_a_whole_small_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every sentence has its number, every picture is there; a second run repeats the page."""
    monkeypatch.setattr(
        results_plan, "STRONGEST", {name: STRONGEST[name] for name in list(STRONGEST)[:2]}
    )
    said = io.StringIO()

    def run(out: Path) -> str:
        console = Console(file=said)
        return make_results("tiny", Backend(), out, tmp_path / "pieces", console).read_text()

    text = run(tmp_path / "a")
    assert "simulated people" in text
    assert "nan" not in text
    assert "{" not in text
    pictures = re.findall(r"\]\((results/[^)]+\.svg)\)", text)
    assert len(set(pictures)) == 8
    for picture in pictures:
        assert b"simulated people" in (tmp_path / "a" / picture).read_bytes()
        with (tmp_path / "a" / picture).with_suffix(".csv").open() as file:
            assert list(csv.DictReader(file))
    monkeypatch.setattr(results, "draw_figures", lambda found: {})
    before = {place: place.stat().st_mtime_ns for place in (tmp_path / "pieces").iterdir()}
    assert run(tmp_path / "b") == text
    assert {place: place.stat().st_mtime_ns for place in (tmp_path / "pieces").iterdir()} == before
    assert re.search(r"learning runs: (\d+) pieces, \1 of them there already", said.getvalue())
    for file in (tmp_path / "b" / "results").iterdir():
        assert file.read_bytes() == (tmp_path / "a" / "results" / file.name).read_bytes()


@pytest.mark.parametrize("words", [FALLS, SHORTER, LEFT])
def test_every_outcome_is_worded(words: dict[Verdict, str]) -> None:
    assert set(words) == set(Verdict)
    assert len(set(words.values())) == len(Verdict)
    assert words[Verdict.FOUND].startswith("**Found.**")
    assert words[Verdict.NOT_FOUND].startswith("**Not found.**")
    assert words[Verdict.OPPOSITE].startswith("**The opposite was found.**")


def test_numbers_have_their_sign_but_no_minus_nought() -> None:
    assert [signed(value) for value in (-0.4, 0.4, 3.6, -3.6)] == ["0", "0", "+4", "-4"]
    assert signed(-0.44, 1) == "-0.4"
