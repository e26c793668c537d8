"""What the drops of a session say of the antennas stands beside the setup, and is taken over where that is wanted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.file_samples import result_of
from support.gui_sessions import make_session

from radargui.files.run_file import read_run, read_run_setup
from radargui.files.run_results import write_results
from radargui.gui.main_window import MainWindow
from radargui.model.setup_posterior import SetupLikelihood, unknown_inputs


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """A session whose drop has the second receiver one u (0.5 degrees) further down, ten times as well known."""
    path = make_session(tmp_path / "data", 4)
    (run,) = path.glob("run-*.h5")
    setup = read_run_setup(run)
    assert setup is not None
    keys = [one.key for one in unknown_inputs(setup)[0]]
    said = np.zeros(len(keys))
    said[keys.index("receiver[2].tilt_deg")] = 100.0
    made = replace(result_of(read_run(run)), setup=setup, setup_likelihood=SetupLikelihood(np.diag(said), said))
    write_results(run, made)
    return path


def test_the_drops_of_a_session_that_is_opened_are_shown_beside_the_antennas_and_taken_over(
    own_window: MainWindow, session: Path, wait_for: Any
) -> None:
    window, group = own_window, own_window.antennas.calibration
    assert not window.sketch.drops
    window.sessions.open(session)
    wait_for(lambda: window.sketch.drops)
    # beside the antenna from the side, from where its tilt is seen
    second = window.sketch.places[2]
    _, tilt, said, *_ = window.sketch.words_beside(0, second).split("\n")
    assert tilt == "tilt 40°"
    assert said.startswith("drops: 40.49")
    assert said.endswith("pull +1.0")
    assert "pull" not in window.sketch.words_beside(1, second).split("\n")[0]
    # the setup of a session is not edited: first it becomes the operator's own
    assert not group.take_over.isEnabled()
    window.actions_.take_over.trigger()
    before = window.setup_model.setup
    group.take_over.click()
    taken = window.setup_model.setup
    tilts = [one.receiver[1].tilt_deg for one in (before, taken)]
    assert tilts[1] - tilts[0] == pytest.approx(0.5 * 100.0 / 101.0, abs=1e-3)
    assert taken.receiver[1].u_tilt_deg == pytest.approx(0.05, rel=0.01)
    assert taken.tracer == before.tracer
    assert taken.calibration.content is not None
    window.actions_.undo_setup.trigger()
    assert window.setup_model.setup.calibration.content is None
