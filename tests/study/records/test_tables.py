"""Guards cells: exact figures, UTC times, and nothing that a spreadsheet would run."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.records.codebook import CODEBOOK, ItemEntry, codebook_rows
from study.records.events import EVENT_KINDS
from study.records.tables import (
    ROBOTS,
    TABLES,
    TRIALS,
    Column,
    format_cell,
    format_row,
    neutralise_formula,
)

TEXT = Column("a", "text", "")
NUMBER = Column("a", "number", "")


def test_trials_and_robots_have_the_published_columns() -> None:
    assert ",".join(TRIALS.header[:19]) == (
        "trial_id,participant_code,mode,is_bot,position,condition,scale,seed,config_hash,"
        "policy_sha256,status,ticks,duration_s,sum_wait_s,sum_completion_s,slowest_robot_s,"
        "human_path_m,human_still_s,blocked_by_human_s"
    )
    assert ",".join(ROBOTS.header[:7]) == (
        "trial_id,robot,boxes_delivered,wait_s,completion_s,path_m,longest_stall_s"
    )


def test_every_row_says_where_it_comes_from_and_no_column_stands_twice() -> None:
    for table in TABLES.values():
        assert {"study_id", "config_hash", "mode", "is_bot"} <= set(table.header)
        assert len(set(table.header)) == len(table.header)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_figures_are_exact(value: float) -> None:
    assert float(format_cell(NUMBER, value)) == value


def test_cells_of_each_kind() -> None:
    assert format_cell(TEXT, None) == ""
    assert format_cell(Column("a", "boolean", ""), True) == "true"
    assert format_cell(Column("a", "integer", ""), -3) == "-3"
    moment = datetime(2026, 1, 2, 3, 4, 5, 6789, tzinfo=timezone(timedelta(hours=2)))
    assert format_cell(Column("a", "time", ""), moment) == "2026-01-02T01:04:05.006Z"
    assert format_cell(Column("a", "time", ""), moment.astimezone(UTC)).endswith("Z")


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@x", "\tx", "\rx", "＝1"])
def test_what_a_spreadsheet_would_run_is_neutralised_in_texts_only(text: str) -> None:
    assert format_cell(TEXT, text) == "'" + text
    assert format_cell(NUMBER, -1.5) == "-1.5"


@given(st.text(max_size=30))
def test_a_neutralised_text_never_begins_a_formula_and_loses_nothing(text: str) -> None:
    cell = neutralise_formula(text)
    assert cell[:1] not in tuple("=+-@\t\r\n")
    assert cell in (text, f"'{text}")


def test_a_missing_column_is_noticed() -> None:
    with pytest.raises(KeyError):
        format_row(ROBOTS, {"trial_id": "x"})


def test_the_codebook_lists_every_column_and_item() -> None:
    item = ItemEntry("h", "questionnaire", "Q1", "scale", "Easy?", (("1", "no"), ("2", "yes")))
    rows = list(codebook_rows([item]))
    columns = sum(len(table.columns) for table in TABLES.values())
    events = sum(1 + len(kind.fields) for kind in EVENT_KINDS.values())
    assert len(rows) == columns + events + 1
    assert rows[-1]["levels"] == "1=no|2=yes"
    assert all(set(row) == set(CODEBOOK.header) for row in rows)
