"""The live track's tests for a fall where g is another than on Earth."""

from __future__ import annotations

import pytest
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.live.trigger import FallTest


@pytest.mark.parametrize("gravity_m_s2", [1.0, 3.0, 25.0])
@pytest.mark.parametrize("simulation", [{}, {"drop_height_m": 0.03}, {"drop_height_m": 0.05, "snr_db": 25.0}])
def test_a_drop_is_a_fall_at_the_sites_g(gravity_m_s2: float, simulation: dict[str, float]) -> None:
    setup = simulated_setup(**{"rest_s": 0.3, "settle_s": 0.2, "gravity_m_s2": gravity_m_s2, **simulation})
    setup = changed(setup, site={"g_m_s2": gravity_m_s2})
    recording, _ = simulate_recording(setup)
    test = FallTest(setup, recording.digitisation)
    test.push(recording.raw)
    assert test.has_fall()


def test_what_falls_at_a_third_of_the_sites_g_is_no_fall() -> None:
    setup = simulated_setup(rest_s=0.3, settle_s=0.2, gravity_m_s2=3.0)
    recording, _ = simulate_recording(setup)
    test = FallTest(setup, recording.digitisation)
    test.push(recording.raw)
    assert not test.has_fall()
