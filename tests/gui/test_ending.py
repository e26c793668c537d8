"""A logout or shutdown closes the window and the run in it, without a question."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from support.killing import ROOT

from radargui.files.run_file import read_run, run_is_complete


@pytest.mark.skipif(sys.platform == "win32", reason="signals of another system")
def test_what_ends_the_program_closes_the_run_and_the_window(tmp_path: Path, setup_path: Path) -> None:
    environment = {key: value for key, value in os.environ.items() if not key.startswith("XDG_")}
    environment |= {"PYTHONPATH": os.pathsep.join([str(ROOT / "tests"), str(ROOT)]), "HOME": str(tmp_path)}
    environment |= {"QT_QPA_PLATFORM": "offscreen"}
    command = [sys.executable, "-m", "support.ended_window", str(setup_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment) as child:
        assert child.stdout is not None
        try:
            run = Path(child.stdout.readline().strip())
            # each of the signals that `on_ending` heeds is sent to the command line, see tests/cli/test_ending.py
            child.send_signal(signal.SIGTERM)
            # a window that hears nothing would hold the test for ever
            _, errors = child.communicate(timeout=60.0)
        finally:
            child.kill()
    assert child.returncode == 0, errors
    assert "Traceback" not in errors
    assert run.is_relative_to(tmp_path)
    assert read_run(run).n_samples > 0
    assert run_is_complete(run)
