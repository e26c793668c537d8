"""Story: the cable is pulled in the middle of a series; nothing is lost, one sentence says so, the series goes on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
from support.window_clocks import FastClock

from radargui.gui.control.state import AppState
from radargui.model.errors import SourceError
from radargui.model.recording import Block
from radargui.sources.factory import make_source


class Cable:
    """Makes simulated sources that end as a device does whose cable is pulled, and remembers what they gave."""

    def __init__(self) -> None:
        self.pulled = False
        self.blocks: list[Block] = []

    def __call__(self, kind: Any, setup: Any, **options: Any) -> Any:
        source = make_source(kind, setup, clock=FastClock(8.0), **options)
        read = source.read
        self.blocks = []

        def through() -> Block | None:
            if self.pulled:
                raise SourceError(
                    "The device was removed", reasons=("its cable was pulled",), remedy="Plug it in and press Record."
                )
            block: Block | None = read()
            if block is not None:
                self.blocks.append(Block(block.samples.copy(), block.first_index))
            return block

        source.read = through
        return source


def raw_of(path: Path) -> Any:
    with h5py.File(path) as file:
        return file["raw"][:]


def test_a_cable_pulled_in_a_series_loses_nothing_and_the_series_goes_on(
    make_window: Any, setup_path: Path, wait_for: Any
) -> None:
    cable = Cable()
    window = make_window(setup_path, source_maker=cable)
    window.setup_model.assign("processing.correction", "published")
    window.bar.runs.setValue(9)
    window.actions_.record.trigger()
    # the first drop is through, another one is being recorded
    wait_for(lambda: window.runs.model.entries and window.control.state is AppState.RECORDING)
    cable.pulled = True
    wait_for(lambda: window.control.state is AppState.FAILED)
    given = np.concatenate([block.samples for block in cable.blocks], axis=1)

    (said,) = [notice for notice in window.board.notices if notice.level == "error"]
    remedy = "The device was removed. Likely: its cable was pulled. Plug it in and press Record."
    assert said.text.startswith(f"{remedy} What was recorded is kept in ")
    session = window.control.session
    assert session is not None
    paths = session.run_paths(with_rejected=True)
    for path in paths:
        kept = raw_of(path)
        begins = np.flatnonzero((given[:, : -kept.shape[1] + 1] == kept[:, :1]).all(axis=0))
        assert any(np.array_equal(given[:, at : at + kept.shape[1]], kept) for at in begins), (
            "samples of a run are lost"
        )
    wait_for(lambda: window.runs.model.entries[0].summary is not None)
    assert window.runs.model.entries[0].summary["e"] is not None
    before = {path: raw_of(path) for path in paths}

    cable.pulled = False
    window.bar.runs.setValue(1)
    window.actions_.record.trigger()
    wait_for(lambda: window.control.state in (AppState.DONE, AppState.FAILED) and window.control.kept)
    assert window.control.session.path == session.path, "the same series"
    assert window.control.state is AppState.DONE
    assert len(window.control.session.run_paths(with_rejected=True)) == len(paths) + 1
    assert window.runs.model.entries[-1].summary["e"] is not None
    for path, samples in before.items():
        np.testing.assert_array_equal(raw_of(path), samples)
