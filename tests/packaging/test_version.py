"""The version stands in one place; what repeats it for others repeats it right."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from radargui import __version__

ROOT = Path(__file__).resolve().parents[2]


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_build_reads_the_version_where_the_program_does() -> None:
    project = tomllib.loads(text("pyproject.toml"))
    assert "version" in project["project"]["dynamic"]
    assert project["tool"]["hatch"]["version"]["path"] == "radargui/__init__.py"


def test_what_repeats_the_version_agrees() -> None:
    assert re.search(rf"^version: {re.escape(__version__)}$", text("CITATION.cff"), re.MULTILINE)
    metainfo = text("packaging/linux/io.github.radargui.RadarGUI.metainfo.xml")
    assert re.search(rf'<release version="{re.escape(__version__)}"', metainfo)
    assert re.search(rf"^## {re.escape(__version__)}$", text("CHANGELOG.md"), re.MULTILINE)
