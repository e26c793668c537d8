"""A device is unplugged in the middle of a series: what was recorded is kept, and the series can be gone on with."""

from __future__ import annotations

from typing import Any

import numpy as np
from support.window_clocks import FastClock

from radargui.files.run_file import read_run
from radargui.gui.control.state import AppState
from radargui.model.errors import SourceError
from radargui.session.session import Session
from radargui.sources.factory import make_source


class Cable:
    """Between the window and its simulated sources: pulled out, a read fails as that of a device does."""

    def __init__(self) -> None:
        self.out = False

    def source(self, kind: Any, setup: Any, **options: Any) -> Any:
        made, cable = make_source(kind, setup, clock=FastClock(8.0), **options), self
        read = made.read

        def read_through() -> Any:
            if cable.out:
                raise SourceError("The device was removed", remedy="Plug it in again.")
            return read()

        made.read = read_through
        return made


def test_a_series_outlives_a_device_that_is_unplugged_in_its_middle(
    make_window: Any, setup_path: Any, wait_for: Any
) -> None:
    cable = Cable()
    window = make_window(setup_path, source_maker=cable.source)
    control, entries = window.control, window.runs.model
    # a hand that puts the sphere back is no drop, but here it would be another run
    window.setup_model.assign("recording.falls_only", False)
    window.bar.runs.setValue(5)
    window.actions_.record.trigger()
    wait_for(lambda: entries.entries and control.state is AppState.RECORDING)
    cable.out = True
    wait_for(lambda: not control.state.running)
    assert control.state is AppState.FAILED
    assert any("The device was removed" in text and "Plug it in again" in text for text in window.strip.texts())
    wait_for(lambda: not window.jobs.running)
    session = control.session
    assert session is not None
    kept = session.run_paths(with_rejected=True)
    assert len(kept) >= 2
    for path in kept:
        run = read_run(path)
        # whole blocks, in order, to the last one that was read
        assert run.n_samples > 1000
        assert np.isfinite(run.volts()).all()
        assert run.gaps == ()
    assert entries.entries[0].summary
    cable.out = False
    window.bar.runs.setValue(1)
    window.actions_.record.trigger()
    wait_for(lambda: control.state is AppState.DONE)
    assert control.session is not None
    assert control.session.path == session.path
    again = Session.open(session.path, write=False).run_paths(with_rejected=True)
    assert [path.name for path in again[: len(kept)]] == [path.name for path in kept]
    assert len(again) == len(kept) + 1
    assert ": e = " in window.bar.state.text
