"""The hashed locks hold on every system and every Python, and name no address."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RUN, DEV, PACKAGE = (ROOT / "packaging" / f"requirements{kind}.txt" for kind in ("", "-dev", "-package"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def entries(path: Path) -> dict[str, str]:
    """Return each locked package with its version."""
    found = re.findall(r"^([A-Za-z0-9._-]+)==(\S+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    return dict(found)


def wanted(requirements: list[str]) -> set[str]:
    return {re.split(r"[\[<>=!~; ]", text, maxsplit=1)[0].lower().replace("_", "-") for text in requirements}


@pytest.mark.parametrize("path", [RUN, DEV, PACKAGE], ids=lambda path: path.name)
def test_a_lock_holds_versions_with_hashes_and_nothing_else(path: Path) -> None:
    for line in path.read_text(encoding="utf-8").replace("\\\n", "").splitlines():
        if line.startswith("#"):
            continue
        assert re.fullmatch(r"[a-z0-9.-]+==[^ ;]+( ; [^\"#:/]+)?( +--hash=sha256:[0-9a-f]{64})+", line), line


@pytest.mark.parametrize("path", [RUN, DEV, PACKAGE], ids=lambda path: path.name)
def test_a_lock_names_each_package_once_for_every_python(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert len(entries(path)) == text.count("==") - text.count("sys_platform ==")
    assert "python_full_version" not in text
    assert "python_version" not in text


def test_the_lock_for_running_holds_every_dependency_and_what_builds_the_project() -> None:
    needed = wanted(PROJECT["project"]["dependencies"]) | wanted(PROJECT["dependency-groups"]["build"])
    assert needed <= entries(RUN).keys()


def test_the_lock_for_development_holds_the_other_at_the_same_versions_and_all_tools() -> None:
    assert entries(RUN).items() <= entries(DEV).items()
    for name, group in PROJECT["dependency-groups"].items():
        assert wanted(group) <= entries(PACKAGE if name == "package" else DEV).keys()


def test_what_is_packed_is_what_was_tested() -> None:
    tested, packed = entries(DEV), entries(PACKAGE)
    assert entries(RUN).items() <= packed.items()
    assert all(tested[name] == packed[name] for name in tested.keys() & packed.keys())


def test_the_lock_for_running_brings_no_test_tools() -> None:
    assert not wanted(PROJECT["dependency-groups"]["test"]) & entries(RUN).keys()


def test_qt_stays_below_the_version_that_aborts() -> None:
    major, minor, *_ = entries(RUN)["pyside6-essentials"].split(".")
    assert (int(major), int(minor)) < (6, 11)
