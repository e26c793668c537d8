"""The reference of the setup file says what the program allows."""

from __future__ import annotations

import runpy
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def test_the_reference_is_what_the_program_itself_says() -> None:
    reference = runpy.run_path(str(DOCS / "make_setup_reference.py"))["reference"]()
    assert (DOCS / "setup-file.md").read_text(encoding="utf-8") == reference, "run docs/make_setup_reference.py"
