"""Corrections that take each receiver by itself, and a metal sphere whose polarisation is told."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed
from support.estimates import exactly_known
from support.simulated_recording import simulate_recording

from radargui.model.setup import Setup, read_setup
from radargui.processing.process import process
from radargui.system.resources import default_setup_path

CLEAN = {"mismatch": 0.0, "snr_db": 50.0, "sphere": "metal", "lateral_speed_m_s": 0.05, "drag_per_m": 0.0}


def metal() -> Setup:
    setup = changed(
        read_setup(default_setup_path()), daq={"rate_hz": 10000.0, "channel_skew_s": 5e-6}, simulation=CLEAN
    )
    return changed(setup, transmitter={"polarization_deg": 0.0})


def untold(setup: Setup) -> Setup:
    sent = setup.transmitter.model_copy(update={"polarization_deg": None})
    return setup.model_copy(update={"transmitter": sent})


@pytest.mark.parametrize("correction", ["published", "adaptive"])
def test_its_phase_is_taken_off_the_track_and_off_the_paths_where_the_polarisation_is_told(correction: str) -> None:
    # antennas are exact: flights would make up for part of the phase by them
    setup = changed(exactly_known(metal()), processing={"correction": correction})
    recording, truth = simulate_recording(setup)
    errors = {}
    for name, own in (("told", setup), ("not told", untold(setup))):
        result = process(recording, own)
        assert result.track is not None
        assert result.paths is not None
        assert result.segment is not None
        part = slice(result.segment.first, result.segment.last)
        path = truth.path_m - truth.path_m[:, :1]
        at = (result.track.position_m - truth.position_m)[:, part][:, result.track.valid[part]]
        along = (result.paths.change_m - path)[:, part][:, result.paths.valid[:, part].all(axis=0)]
        errors[name] = [float(np.sqrt(np.mean(one**2))) for one in (at, along)]
        assert result.uncertainty_budget is not None
        errors[name].append(result.uncertainty_budget.position_m.sphere or 0.0)
    assert errors["told"][0] < 0.7 * errors["not told"][0]
    assert errors["told"][1] < 0.7 * errors["not told"][1]
    # 2 hundredths of a millimetre of diameter and 5 degrees cost less than not to know
    assert 0.0 < errors["told"][2] < 0.5 * errors["not told"][2]
