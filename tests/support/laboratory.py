"""The package of worked plug-ins in docs/examples, as it is when pip has installed it."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from radargui.model.plugins import plugins

PACKAGE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "plugins"


@contextmanager
def installed(folder: Path) -> Iterator[None]:
    """Let its entry points be found, by what an installer would write into `folder`."""
    project = tomllib.loads((PACKAGE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    facts = folder / f"radargui_laboratory-{project['version']}.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    lines = [
        line
        for group, points in project["entry-points"].items()
        for line in (f"[{group}]", *(f"{name} = {place}" for name, place in points.items()))
    ]
    (facts / "entry_points.txt").write_text("\n".join(lines) + "\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [str(folder), str(PACKAGE), *sys.path])
        plugins.cache_clear()
        try:
            yield
        finally:
            plugins.cache_clear()
            for name in [name for name in sys.modules if name.partition(".")[0] == "laboratory"]:
                del sys.modules[name]
