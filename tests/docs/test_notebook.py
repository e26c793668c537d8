"""The worked notebook runs from its first cell to its last, and finds what the simulation put there."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from radargui.model.setup import read_setup

NOTEBOOK = Path(__file__).resolve().parents[2] / "docs" / "examples" / "first-results.ipynb"


def test_every_cell_runs_and_the_truth_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(NOTEBOOK.with_name("quick.toml"), tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    content = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    assert not any(cell.get("outputs") for cell in content["cells"]), "stored without outputs"
    names: dict[str, Any] = {}
    for cell in content["cells"]:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
    truth = read_setup(NOTEBOOK.with_name("quick.toml")).simulation.restitution
    for bounce in (one for one in names["result"].bounces if one.valid):
        assert abs(bounce.e - truth) < 3.0 * bounce.u_e_combined
    assert len(names["first"]) == 3
    assert abs(names["mean"] - truth) < 0.01
    assert "of 3 drops" in capsys.readouterr().out
    assert (tmp_path / "height.png").stat().st_size > 5000
