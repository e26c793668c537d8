"""The window with NI's own client, against a stand-in device server."""

from __future__ import annotations

from typing import Any

import pytest
from support.changed import changed
from support.ni_server import ByHand, serve
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.gui.control.state import AppState
from radargui.model.setup import write_setup
from radargui.sources.factory import make_source


@pytest.mark.parametrize("restart", [False, True])
def test_a_device_is_found_checked_looked_at_and_waits_for_its_edge(
    make_window: Any, tmp_path: Any, wait_for: Any, restart: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    # samples come by hand, and on a busy machine not within the second after which a device counts as silent
    monkeypatch.setattr("radargui.sources.ni.source.EMPTY_READS", 1000)
    still = changed(
        quick_setup(),
        daq={"rate_hz": 20e6 / 2000, "channel_skew_s": 0.0},
        simulation={"scene": "rest", "rest_s": 2.0, "settle_s": 0.0},
    )
    recording, _ = simulate_recording(still)
    pace = ByHand()
    with serve(recording, pace=pace) as server:
        setup = changed(
            still,
            daq={"remote": server.address, "start": "digital", "start_source": "PFI1"},
            recording={"restart_after_error": restart},
        )
        write_setup(setup, tmp_path / "lab.toml")
        window = make_window(tmp_path / "lab.toml", source_maker=make_source)
        window.hardware.choose("ni")
        form = window.hardware.ni
        form.button.click()
        wait_for(form.button.isEnabled)
        assert "DAQPad-6015" in form.found.itemText(0)
        form.check_button.click()
        wait_for(form.check_button.isEnabled)
        assert "The setup works on Dev1" in form.checked.text()
        assert "PFI1" in form.checked.text()

        window.actions_.record.trigger()
        wait_for(lambda: window.bar.state.text.endswith("waiting for rising edge at PFI1"))
        window.actions_.stop.trigger()
        wait_for(lambda: not window.control.state.running)

        # to look at the signal nobody waits for the edge
        pace.waiting.clear()
        window.actions_.start.trigger()
        wait_for(lambda: window.control.state is AppState.LIVE and pace.waiting.is_set())
        pace.advance(2000)
        wait_for(lambda: (feed := window.control.feed) is not None and feed.ring.latest >= 2000)
        window.actions_.stop.trigger()
        wait_for(lambda: not window.control.state.running)
        assert not server.tasks
        assert not [notice for notice in window.board.notices if notice.level == "error"], window.board.notices
