"""Guards that participants of studies stored by earlier versions of the software can go on."""

from __future__ import annotations

import json
from pathlib import Path

from study.config import Study
from study.files.earlier import read_stored
from study.protocol.items import answer_label

FIRST_FORMAT = (Path(__file__).parent / "format-1.json").read_text(encoding="utf-8").strip()
STORED_BY = "c" * 64


def test_a_study_of_the_first_format_is_read_with_the_hash_it_is_stored_by(study: Study) -> None:
    """The file was written by the first format's own code."""
    earlier = read_stored(FIRST_FORMAT, STORED_BY)
    assert earlier.config_hash == STORED_BY
    assert earlier.plan == study.plan
    assert earlier.orders == study.orders
    assert earlier.completion_codes == study.completion_codes
    assert earlier.texts.consent.body.split() == study.texts.consent.body.split()
    assert earlier.panel == study.panel
    assert earlier.limits == study.limits
    for step in ("consent", "demographics", "questionnaire", "comments"):
        items = [item for _, item in earlier.items_asked(step)]
        assert [item.name for item in items] == [item.name for _, item in study.items_asked(step)]
    assert answer_label(earlier.questionnaire[0].items[0], "2") == "Somewhat disagree"


def test_settings_of_the_first_format_are_kept() -> None:
    document = json.loads(FIRST_FORMAT) | {
        "abandon_after_s": 120.0,
        "on_disconnect": "continue",
        "ribbon_widest_at": "robot",
        "panel_fields": ["who"],
        "scale": "small",
    }
    earlier = read_stored(json.dumps(document), STORED_BY)
    assert (earlier.limits.abandon_after_s, earlier.limits.idle_after_s) == (120.0, 120.0)
    assert earlier.limits.on_disconnect == "continue"
    assert earlier.display.ribbon_widest_at == "robot"
    assert earlier.panel.parameters == ("who",)
    assert earlier.scale_at(2) == "small"


def test_a_study_of_today_keeps_its_hash(study: Study) -> None:
    stored = read_stored(study.canonical_json, study.config_hash)
    assert stored == study.stored_as(study.config_hash)
    assert stored.revised(seed=1).config_hash == study.revised(seed=1).config_hash
