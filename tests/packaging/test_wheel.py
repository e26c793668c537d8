"""Wheel and source distribution hold all that the program reads when it runs."""

from __future__ import annotations

import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from radargui import __version__

ROOT = Path(__file__).resolve().parents[2]
HELP = "radargui/resources/help/"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-t", "sdist", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, timeout=100)
    return folder


def below(name: str, left_out: tuple[str, ...] = ("__pycache__",)) -> set[str]:
    files = (path for path in (ROOT / name).rglob("*") if path.is_file())
    return {path.relative_to(ROOT).as_posix() for path in files if not set(left_out) & set(path.parts)}


def test_the_wheel_holds_package_and_resources(made: Path) -> None:
    with zipfile.ZipFile(made / f"radargui-{__version__}-py3-none-any.whl") as wheel:
        names = set(wheel.namelist())
        metadata = wheel.read(f"radargui-{__version__}.dist-info/METADATA").decode()
        entry = wheel.read(f"radargui-{__version__}.dist-info/entry_points.txt").decode()
    assert below("radargui") - names == set()
    assert {f"radargui/{name}" for name in below("resources")} - names == set()
    assert {"radargui/py.typed", "radargui/__init__.pyi"} <= names
    assert f"radargui-{__version__}.dist-info/licenses/LICENSE" in names
    assert "radargui = radargui.cli:main" in entry
    assert "License-Expression: MIT" in metadata


def test_the_wheel_has_help_whether_or_not_its_pages_were_built(made: Path) -> None:
    with zipfile.ZipFile(made / f"radargui-{__version__}-py3-none-any.whl") as wheel:
        there = {name.removeprefix(HELP) for name in wheel.namelist() if name.startswith(HELP)}
        texts = {name: wheel.read(HELP + name).decode() for name in there if name.endswith(".md") and "/" not in name}
    if (ROOT / "build" / "help").is_dir():
        assert "index.html" in there
        return
    assert "tutorial.md" in there
    linked = {link for text in texts.values() for link in re.findall(r"\]\(([^)#:]+)", text)}
    assert linked - there == set(), "pictures, and what the texts lead to"
    assert not any(name.endswith(".py") for name in there)


def test_the_source_distribution_can_be_built_and_tested_from(made: Path) -> None:
    with tarfile.open(made / f"radargui-{__version__}.tar.gz") as source:
        names = {name.partition("/")[2] for name in source.getnames()}
    for folder in ("radargui", "resources", "tests", "packaging"):
        assert below(folder) - names == set()
    assert {"LICENSE", "README.md", "CHANGELOG.md", "pyproject.toml", "docs/method.md"} <= names
