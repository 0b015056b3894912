"""Guards that whatever stands in a file, it is read or refused with places and sentences."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from study.files.demo import demo_entries
from study.files.problems import explain_errors, find_mixed_instruments
from study.files.reading import check_the_rest, validate_entries
from study.protocol.records import show_place

JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**20), 10**20),
    st.floats(),
    st.text(max_size=8),
    st.lists(st.integers() | st.text(max_size=3), max_size=3),
    st.dictionaries(st.text(max_size=6), st.integers() | st.text(max_size=3), max_size=3),
)
FURTHER = {
    "hall": [
        {"name": "own", "shelf_columns": 2, "shelf_rows": 2, "robots": 1, "boxes_per_robot": 1}
    ],
    "exclusion": [{"name": "r", "measure": "hidden_s", "above": 1}],
    "order": {"kind": "fixed", "rows": [["varil", "arroch", "crmiar"]]},
}


def places_in(value: Any, place: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Every place in nested entries."""
    keys = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in keys:
        yield (*place, key)
        if isinstance(inner, dict | list):
            yield from places_in(inner, (*place, key))


WHOLE = copy.deepcopy(dict(demo_entries())) | FURTHER
PLACES = list(places_in(WHOLE))


def put(entries: Any, place: tuple[str | int, ...], value: Any) -> None:
    for key in place[:-1]:
        entries = entries[key]
    if value is None:
        del entries[place[-1]]
    else:
        entries[place[-1]] = value


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(PLACES), JUNK), min_size=1, max_size=3))
def test_any_entries_are_read_or_refused_in_words(
    changes: list[tuple[tuple[str | int, ...], Any]],
) -> None:
    """Entries are replaced or taken out at random, strangers are added."""
    entries = copy.deepcopy(WHOLE)
    for place, value in changes:
        try:
            put(entries, place, value)
        except (KeyError, IndexError, TypeError):
            continue
    find_mixed_instruments(entries)
    try:
        validate_entries(entries)
    except ValidationError as error:
        problems = explain_errors(error, entries)
        assert problems
        problems += check_the_rest(entries, {str(p.place[0]) for p in problems if p.place})
        for problem in problems:
            assert problem.message
            assert "pydantic" not in problem.message
            assert isinstance(show_place(problem.place), str)
