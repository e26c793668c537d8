"""Of signals that are weak that is said first, before what noise makes look like reflectors or a floor that moves."""

from __future__ import annotations

import pytest
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.processing.process import process


@pytest.mark.slow
def test_a_weak_signal_is_the_first_cause_that_is_named() -> None:
    weak = {"snr_db": 6.0, "restitution": 0.6}
    setup = changed(quick_setup(), daq={"rate_hz": 4000.0}, simulation=weak, processing={"correction": "joint"})
    result = process(simulate_recording(setup)[0], setup)
    codes = [one.code for one in result.findings]
    n_weak = codes.count("signal_low")
    assert n_weak > 0
    assert set(codes[:n_weak]) == {"signal_low"}
    assert len(codes) > n_weak, "something else is said, too"
    assert result.warnings[0].endswith("low signal-to-noise ratio")
