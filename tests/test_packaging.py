"""Guards what people meet first: the Makefile's targets, the Dockerfile, the continuous check."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent


def dockerfile_steps() -> list[tuple[str, str]]:
    text = (ROOT / "Dockerfile").read_text().replace("\\\n", " ")
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    return [
        (line.split(None, 1)[0], line.split(None, 1)[1])
        for line in lines
        if not line.startswith(" ")
    ]


def test_every_file_the_dockerfile_copies_exists() -> None:
    """No engine builds the image here, so a renamed file would go unnoticed."""
    copied = [
        word
        for step, rest in dockerfile_steps()
        if step == "COPY" and not rest.startswith("--from")
        for word in shlex.split(rest)[:-1]
    ]
    assert "pyproject.toml" in copied
    assert [name for name in copied if not (ROOT / name).exists()] == []


def test_the_image_has_two_stages_a_plain_user_and_a_health_check() -> None:
    steps = dockerfile_steps()
    kinds = [kind for kind, _ in steps]
    assert kinds.count("FROM") == 2
    assert dict(steps)["USER"] == "varil"
    assert "/healthz" in dict(steps)["HEALTHCHECK"]


def test_the_image_starts_a_command_that_the_package_installs() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    command = json.loads(dict(dockerfile_steps())["CMD"])
    assert command[0] in project["scripts"]
    from server.cli.main import app

    assert command[1] in {info.name or info.callback.__name__ for info in app.registered_commands}


def test_one_version_of_uv_everywhere() -> None:
    """The lock file is read by the version that wrote it."""
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["uv"]["required-version"]
    for name in ("Makefile", "Dockerfile"):
        found = set(re.findall(r"(?:uv==|UV_VERSION := )(\d[\d.]*\d)", (ROOT / name).read_text()))
        assert found == {wanted.removeprefix("==")}, name


def test_the_continuous_check_runs_the_suite() -> None:
    assert "make test" in (ROOT / ".ci/run").read_text()


def test_the_lock_file_of_the_client_names_no_host() -> None:
    """Addresses in it would tie a checkout to one registry; the hashes are enough."""
    assert '"resolved"' not in (ROOT / "package-lock.json").read_text()
