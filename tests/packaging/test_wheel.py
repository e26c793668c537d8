"""Wheel and source distribution hold all that the program reads when it runs."""

from __future__ import annotations

import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from radargui import __version__

ROOT = Path(__file__).resolve().parents[2]


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
    help_pages = {name for name in names if name.startswith("radargui/resources/help/")}
    # the help is in it where it was built
    assert bool(help_pages) == (ROOT / "build" / "help").is_dir()


def test_the_source_distribution_can_be_built_and_tested_from(made: Path) -> None:
    with tarfile.open(made / f"radargui-{__version__}.tar.gz") as source:
        names = {name.partition("/")[2] for name in source.getnames()}
    for folder in ("radargui", "resources", "tests", "packaging"):
        assert below(folder) - names == set()
    assert {"LICENSE", "README.md", "CHANGELOG.md", "pyproject.toml", "docs/method.md"} <= names
