"""Stories once more, as an operator's screen shows them: on a display, the track in space by OpenGL.

By name: RADARGUI_TEST_DISPLAY=1 python3 packaging/dev.py test tests/gui/test_on_a_display.py
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

GUI = Path(__file__).parent
STORIES = (
    "test_unplugged.py::test_a_cable_pulled_in_a_series_loses_nothing_and_the_series_goes_on",
    "test_scopes.py::test_the_bar_of_a_turned_antenna_follows_and_the_highest_is_held",
    "test_series.py::test_three_heights_are_compared",
)


@pytest.mark.timeout(200)
@pytest.mark.skipif(
    shutil.which("xvfb-run") is None or not os.environ.get("RADARGUI_TEST_DISPLAY"),
    reason="needs xvfb-run, and takes its time where OpenGL is software",
)
def test_stories_end_the_same_on_a_display_with_opengl(tmp_path: Path) -> None:
    screen = ["xvfb-run", "-a", "-s", "-screen 0 1920x1080x24"]
    pytest_ = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"--basetemp={tmp_path / 'stories'}"]
    ended = subprocess.run(
        [*screen, *pytest_, *(str(GUI / story) for story in STORIES)],
        env={**os.environ, "QT_QPA_PLATFORM": "xcb", "RADARGUI_TEST_OPENGL": "1"},
        capture_output=True,
        encoding="utf-8",
        timeout=180,
        check=False,
    )
    assert f"{len(STORIES)} passed" in ended.stdout, ended.stdout + ended.stderr
