"""Guards addresses at the end: only what the study wrote, with everything filled in encoded."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from study.protocol.panel import Ending, Panel

ENDING = Ending(code="DONE-1", redirect="https://App.Panel.example/end?cc={code}&who={PID}")


def test_an_address_has_its_code_and_the_panels_number_filled_in() -> None:
    assert ENDING.address({"PID": "5f"}) == "https://App.Panel.example/end?cc=DONE-1&who=5f"
    assert ENDING.address({}) == "https://App.Panel.example/end?cc=DONE-1&who="
    assert (ENDING.host, ENDING.blanks) == ("app.panel.example", ("code", "PID"))
    assert Ending(code="DONE-1").address({}) is None


@given(st.text(max_size=30))
def test_no_number_of_a_panel_leads_elsewhere(number: str) -> None:
    try:
        number.encode()
    except UnicodeEncodeError:
        return
    address = ENDING.address({"PID": number})
    assert address is not None
    start, sent = address.split("&who=")
    assert start == "https://App.Panel.example/end?cc=DONE-1"
    assert all(letter.isascii() and (letter.isalnum() or letter in "-._~%") for letter in sent)


def test_the_first_parameter_tells_people_apart_unless_another_is_named() -> None:
    assert Panel().person_parameter == "PROLIFIC_PID"
    assert Panel(parameters=("a", "b"), identifier="b").person_parameter == "b"
    assert Panel(parameters=()).person_parameter is None
