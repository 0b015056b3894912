"""Which version of a study is served, and what that means for those who have joined already."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from server.store.engine import Database
from server.store.policies import keep_policy
from server.store.studies import VersionEntry, drop_drafts, keep_version, list_entries
from server.study_files import ReadStudy
from study.config import Study


async def register_versions(database: Database, read: Sequence[ReadStudy]) -> list[str]:
    """Store what is served now, with its policies; returns a sentence about each study.

    A version that nobody joined was a draft and is replaced; one with participants stays for ever.
    """
    now = datetime.now(UTC)
    sentences = []
    async with database.writing() as session:
        for entry in read:
            if entry.policy is not None:
                await keep_policy(session, entry.policy, "uploaded", now)
            await keep_version(session, entry.study, now)
            await drop_drafts(session, entry.study)
            versions = await list_entries(session, entry.study.study_id)
            sentences.append(describe_version(entry.study, versions))
    return sentences


def describe_version(study: Study, versions: Sequence[VersionEntry]) -> str:
    """What is served, in one sentence; `versions` hold those with participants and this one."""
    name, short = f"Study “{study.study_id}”", study.config_hash[:12]
    current = next(one for one in versions if one.config_hash == study.config_hash)
    others = [one for one in versions if one.joined and one is not current]
    if current.joined:
        return f"{name}: version {current.number} ({short}), frozen; joined by {current.joined}"
    if not others:
        return f"{name}: version {current.number} ({short}), not joined by anybody yet"
    before = others[-1]
    return (
        f"{name} has changed: version {current.number} ({short}) for newcomers; "
        f"{before.joined} who joined version {before.number} ({before.config_hash[:12]}) keep it"
    )
