"""Guards the door between export and analysis: what the server writes, the analysis reads."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from server.analysis.run import AnalysisOptions, analyze
from server.store.engine import Database
from server.store.schema import migrate
from study.config import Study
from tests.server.export.site import MakeResult, Site, export


async def test_an_export_of_the_server_is_analysed(
    study: Study, make_result: MakeResult, tmp_path: Path
) -> None:
    """Two who completed, one who stopped on the way, one who withdrew."""
    database = Database(f"sqlite:///{tmp_path}/a.sqlite3")
    await migrate(database)
    site = Site(database, study, make_result)
    await site.people.register_studies()
    for steps, rating in ((15, "4"), (15, "2"), (8, "5")):
        await site.walk(steps, rating, "=1+1")
    await site.people.withdraw(await site.walk(15, "1", ""))
    (tmp_path / "demo.zip").write_bytes(await export(database))
    await database.close()
    summary = analyze(AnalysisOptions(tmp_path / "demo.zip", tmp_path / "out"))
    assert (summary["mode"], summary["marked_as"]) == ("pilot", "pilot data")
    assert (summary["participants"], summary["analysed"]) == (4, 2)
    assert summary["conditions"] == list(study.conditions)
    rows = pd.read_csv(tmp_path / "out/tables/team_descriptives.csv")
    assert rows.loc[rows["measure"] == "sum_wait_s", "mean"].eq(22.0).all()
    items = pd.read_csv(tmp_path / "out/tables/item_descriptives.csv")
    assert items["mean"].eq(3.0).all()
    assert set(items["item"]) == {f"Q{k}" for k in range(1, 7)}
