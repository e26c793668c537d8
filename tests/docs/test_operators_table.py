"""The table of what operators ask for names tests that are there."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DEMANDS = 28


def test_every_demand_names_tests_that_exist() -> None:
    text = (ROOT / "docs" / "operators-ask.md").read_text(encoding="utf-8")
    rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| ")][1:]
    assert len(rows) == DEMANDS
    there = {
        name
        for path in (ROOT / "tests").rglob("test_*.py")
        for name in re.findall(r"^ *def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    }
    for asked, how, shown in rows:
        names = re.findall(r"`(\w+)`", shown)
        assert how.strip(), asked
        assert names, asked
        assert set(names) <= there, (asked, set(names) - there)
