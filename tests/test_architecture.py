"""Guards the house: which room may know which, in Python and in the browser's code."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

IMPURE = {
    "aiosqlite", "alembic", "asyncio", "fastapi", "http", "io", "os", "pathlib", "random",
    "server", "shutil", "socket", "sqlalchemy", "starlette", "subprocess", "tempfile",
    "threading", "time", "urllib", "uvicorn",
}  # fmt: skip
ROOMS_OF_STUDY = {  # a room may import itself and the rooms named behind it
    "errors": set(),
    "warehouse": {"errors"},
    "ar": {"errors", "warehouse", "learning.policy"},
    "learning": {"errors", "warehouse", "ar"},
    "people": {"errors", "warehouse", "ar", "learning"},
    "records": {"errors", "warehouse", "ar", "learning"},
    "protocol": {"errors", "config", "warehouse"},
    "config": {"errors", "warehouse", "ar", "protocol"},
    "files": {"errors", "protocol", "config"},
    "policies": set(),
    "headless": {"errors", "warehouse", "ar", "learning", "people", "records"},
    "analysis": {"errors", "records"},
}
HEAVY = ("sklearn", "scipy", "joblib", "matplotlib", "pandas", "numba", "alembic")


def python_files(folder: str) -> list[Path]:
    return sorted((ROOT / folder).rglob("*.py"))


def imported_modules(path: Path) -> Iterator[tuple[int, str]]:
    package = list(path.relative_to(ROOT).with_suffix("").parts[:-1])
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            yield node.lineno, ".".join([*base, node.module or ""]).strip(".")
            if node.module in {"study", "server"} or not node.module:
                for alias in node.names:
                    yield node.lineno, ".".join([*base, node.module or "", alias.name]).strip(".")


def offences(folder: str, forbidden: set[str], except_below: str = "-") -> list[str]:
    return [
        f"{path.relative_to(ROOT)}:{line} imports {module}"
        for path in python_files(folder)
        if not path.is_relative_to(ROOT / except_below)
        for line, module in imported_modules(path)
        if any(module == name or module.startswith(f"{name}.") for name in forbidden)
    ]


def test_the_core_is_pure() -> None:
    """`study/` knows no socket, SQL, file, wall clock or global random generator."""
    assert offences("study", IMPURE) == []


def test_the_core_draws_from_no_global_generator_and_reads_no_clock() -> None:
    """Seeds and clocks are handed in, so a trial can be run again."""
    pattern = re.compile(
        r"np\.random\.(seed|rand|randint|random|choice|shuffle)\(|datetime\.now\(|\bopen\("
    )
    found = [
        f"{path.relative_to(ROOT)}:{number}"
        for path in python_files("study")
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if pattern.search(line)
    ]
    assert found == []


def test_rooms_of_the_core_know_only_lower_rooms() -> None:
    """errors < warehouse < ar < learning, people < headless; the others beside them."""
    wrong = []
    for path in python_files("study"):
        parts = path.relative_to(ROOT / "study").with_suffix("").parts
        room = parts[0]
        if room == "__init__":
            continue
        assert room in ROOMS_OF_STUDY, f"{path} stands in a room this test does not know"
        for line, module in imported_modules(path):
            if not module.startswith("study."):
                continue
            target = module.removeprefix("study.")
            allowed = ROOMS_OF_STUDY[room] | {room}
            if not any(target == name or target.startswith(f"{name}.") for name in allowed):
                wrong.append(f"{path.relative_to(ROOT)}:{line} imports {module}")
    assert wrong == []


def test_only_the_store_knows_sql() -> None:
    """SQLAlchemy is imported below `server/store/` alone."""
    assert offences("server", {"sqlalchemy"}, except_below="server/store") == []


def test_pages_and_live_do_not_know_each_other() -> None:
    """What both need reaches them from `server/app.py`."""
    assert offences("server/pages", {"server.live"}) == []
    assert offences("server/live", {"server.pages", "server.store"}) == []


def test_pages_and_programs_ask_desks() -> None:
    """Whoever answers a request opens no transaction; desks own them all."""
    opened = [
        f"{path.relative_to(ROOT)}:{number}"
        for folder in ("server/pages", "server/api", "server/live")
        for path in python_files(folder)
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if re.search(r"\.(reading|writing)\(\)", line)
    ]
    assert opened == []


def test_migrations_import_nothing_of_ours() -> None:
    """An old revision must run years later, whatever the code has become."""
    assert offences("migrations/versions", {"server", "study"}) == []


def test_the_browser_rooms_do_not_import_one_another() -> None:
    """Only an entry brings net, scene, input and ui together."""
    sources = ROOT / "web/static/js"
    wrong = []
    for path in sorted(sources.rglob("*.js")):
        folder = path.parent.relative_to(sources).as_posix()
        if folder == ".":
            continue
        for target in re.findall(r"from \"(\.[^\"]+)\"|import\(\"(\.[^\"]+)\"\)", path.read_text()):
            place = (path.parent / (target[0] or target[1])).resolve()
            if not place.is_relative_to(sources / folder):
                wrong.append(f"{path.relative_to(ROOT)} imports {place.relative_to(sources)}")
    assert wrong == []


def test_the_web_process_stays_light() -> None:
    """Loading the app loads no learning, plotting, compiling or migrating library."""
    code = f"import sys, server.serving\nprint([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr


@pytest.mark.parametrize("folder", ["server", "study", "web/static/js", "tests", "migrations"])
def test_a_file_has_one_subject(folder: str) -> None:
    """No source file grows past 300 lines."""
    long = {
        str(path.relative_to(ROOT)): path.read_text().count("\n")
        for ending in ("*.py", "*.js")
        for path in sorted((ROOT / folder).rglob(ending))
    }
    assert {name: lines for name, lines in long.items() if lines > 300} == {}
