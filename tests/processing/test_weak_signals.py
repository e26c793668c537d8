"""Of signals that are weak that is said first, before what noise makes look like reflectors or a floor that moves."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.correction.quality import WEAK
from radargui.model.channel_quality import ChannelQuality
from radargui.model.finding import warn
from radargui.model.result import CorrectedIQ, PathLengths
from radargui.processing.measured_motion import MeasuredMotion
from radargui.processing.process import process


def test_receivers_that_are_hardly_heard_are_rejected_for_that() -> None:
    time_s, nothing = np.arange(8) / 1e3, np.zeros((3, 8))
    heard = (ChannelQuality("1", snr_db=4.0), ChannelQuality("2", snr_db=30.0), ChannelQuality("3", finding=warn(WEAK)))
    valid = np.ones((3, 8), dtype=np.bool_)
    corrected = CorrectedIQ(time_s, nothing, nothing, valid, nothing, "adaptive", heard)
    motion = MeasuredMotion(corrected, PathLengths(time_s, nothing, nothing, nothing, valid), None)
    refused = motion.refused(warn("no_single_body")).corrected.channels
    assert [one.verdict for one in refused] == ["rejected"] * 3
    assert [one.finding.code for one in refused if one.finding] == [WEAK, "no_single_body", WEAK]


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
