"""The uncertainty expected over the field of view, against the budget of simulated drops and against geometry."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed
from support.small_setups import quick_setup

from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.processing.expected_uncertainty import expected_uncertainty
from radargui.processing.process import process
from radargui.sources.factory import make_source


def drop_of(setup: Setup) -> Recording:
    """Return a simulated drop."""
    source = make_source("simulated", setup, realtime=False)
    digitisation = source.open()
    source.start()
    blocks = []
    while (block := source.read()) is not None:
        blocks.append(block.samples)
    source.close()
    return Recording("drop", np.concatenate(blocks, axis=1), digitisation)


@pytest.mark.parametrize("geometry", ["exact", "plane"])
def test_no_drop_is_less_certain_than_the_map_and_its_flights_make_it_surer(geometry: str) -> None:
    setup = changed(
        quick_setup(),
        daq={"rate_hz": 5000.0, "channel_skew_s": 0.0},
        processing={"correction": "adaptive", "geometry": geometry},
        simulation={"lateral_speed_m_s": 0.1, "restitution": 0.5},
    )
    result = process(drop_of(setup), setup)
    track, segment = result.track, result.segment
    assert track is not None
    assert track.u_combined_m is not None
    assert segment is not None
    few = np.linspace(segment.first + 50, segment.last - 50, 9).astype(int)
    few = few[track.valid[few]]
    assert few.size >= 7
    # without noise on both sides: what a correction leaves is not in the map
    found = expected_uncertainty(track.position_m[:, few], setup, 200.0)
    assert found is not None
    of_setup = np.sqrt(track.u_combined_m[:, few] ** 2 - track.u_position_m[:, few] ** 2)
    # the map knows what is stated, a drop also what its flights tell of it
    assert (of_setup < 1.03 * found[0]).all()
    assert of_setup.max() > 0.3 * found[0].max()
    # over the way, not at one place
    assert np.ptp(found[0], axis=1).max() > 0.3 * found[0].min()


def test_ten_times_the_noise_is_ten_times_the_share_of_noise() -> None:
    place = np.array([[0.0, 0.0], [0.0, 0.1], [0.12, 0.0]])
    budgets = [expected_uncertainty(place, quick_setup(), snr_db) for snr_db in (40.0, 20.0)]
    shares = [found[1].position_m for found in budgets if found is not None]
    assert shares[1].statistical == pytest.approx(10.0 * (shares[0].statistical or 0.0))
    assert shares[1].calibration == shares[0].calibration


def test_two_receivers_tell_no_place() -> None:
    setup = quick_setup()
    two = setup.model_copy(update={"receiver": setup.receiver[:2]})
    assert expected_uncertainty(np.zeros((3, 1)), two, 40.0) is None
