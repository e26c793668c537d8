"""The calibration's share of a joint result against processing again with an antenna elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.scenes.draw import draw_scene
from benchmarks.scenes.scene import make_record
from support.changed import changed

from radargui.model.assumed import CONTACT_S
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.offline import process

U_TILT_DEG = 0.5


def with_receiver(setup: Setup, **keys: float) -> Setup:
    plain = setup.model_dump(by_alias=True)
    plain["receiver"][0].update(keys)
    return Setup.model_validate(plain)


def told(result: RunResult) -> bool:
    return any(warning.startswith("the flights bend") for warning in result.warnings)


def test_e_g_and_position_move_with_an_antenna_as_the_budget_says() -> None:
    fixed = {"rate_hz": 2500.0, "snr_db": 40.0, "skew_s": 0.0, "floor": 0.0, "wall": 0.0, "flicker": 0.0}
    record = make_record(draw_scene(9, "physical", "drop", drag=0.0, e=0.7, height_m=0.2, moving_s=0.5, **fixed))
    recording = record.recording
    joint = changed(record.setup, processing={"correction": "joint"}, floor={"normal": (0.0, 0.0, 1.0)})
    exact = dict.fromkeys(("u_tilt_deg", "u_azimuth_deg", "u_distance_m"), 0.0)
    plain = joint.model_dump(by_alias=True)
    for receiver in plain["receiver"]:
        receiver.update(exact)
    plain["transmitter"]["u_distance_m"] = plain["tracer"]["u_release_m"] = 0.0
    plain["radar"].update(u_frequency_hz=0.0, refractive_index=1.0)
    plain["floor"]["u_tilt_deg"] = plain["daq"]["u_clock_ppm"] = 0.0
    setup = with_receiver(Setup.model_validate(plain), u_tilt_deg=U_TILT_DEG)
    tilt = setup.receiver[0].tilt_deg
    # what nothing is uncertain of is so by any correction: the quick one
    quick = changed(with_receiver(setup, u_tilt_deg=0.0), processing={"correction": "published"})
    certain = process(recording, quick).uncertainty_budget
    assert certain is not None
    assert certain.g_m_s2.calibration == 0.0
    here = process(recording, setup)
    # two deviations: minima are found to a tenth of u, and of one e moves by no more than its own u
    there = process(recording, with_receiver(setup, tilt_deg=tilt + 2.0 * U_TILT_DEG))
    budget = here.uncertainty_budget
    assert budget is not None
    assert budget.assumed == {"tracer.u_diameter_m": 2e-5}
    assert here.track is not None
    assert there.track is not None
    assert here.segment is not None
    assert here.bounces.free_fall is not None
    assert there.bounces.free_fall is not None
    part = slice(here.segment.first, here.segment.last)
    moved = (there.track.position_m - here.track.position_m)[:, part] / 2.0
    assert budget.position_m.calibration == pytest.approx(float(np.sqrt(np.nanmean(moved**2))), rel=0.05)
    e = (there.bounces.impacts[0].e - here.bounces.impacts[0].e) / 2.0
    first = here.bounces.impacts[0]
    # what the impact itself lasts is no antenna's: its square is added
    contact = NOMINAL_GRAVITY_M_S2 * CONTACT_S * (1.0 - first.e) / first.speed_before_m_s
    assert budget.e.calibration is not None
    assert np.sqrt(budget.e.calibration**2 - contact**2) == pytest.approx(abs(e), rel=0.3)
    g = (there.bounces.free_fall.g_m_s2 - here.bounces.free_fall.g_m_s2) / 2.0
    assert budget.g_m_s2.calibration == pytest.approx(abs(g), rel=0.1)
    # else the test would compare noise with noise
    assert abs(e) > 5e-6
    assert abs(g) > 2.0 * here.bounces.free_fall.u_g_m_s2
    # the wrong antenna bends the flights: that is told where its uncertainty does not hold it
    sure = process(recording, with_receiver(setup, tilt_deg=tilt + U_TILT_DEG, u_tilt_deg=0.0))
    assert [told(one) for one in (here, there, sure)] == [False, False, True]
