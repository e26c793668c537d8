"""The calibration's share of a joint result against processing again with an antenna elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.scene import make_record
from support.changed import changed

from radargui.model.result import Bounce, Bounces, FreeFall, RunResult, Segment, Track
from radargui.model.setup import Setup
from radargui.processing.process import process
from radargui.processing.uncertainty_budget import with_budget

U_TILT_DEG = 0.5


def with_receiver(setup: Setup, **keys: float) -> Setup:
    plain = setup.model_dump(by_alias=True)
    plain["receiver"][0].update(keys)
    return Setup.model_validate(plain)


def told(result: RunResult) -> bool:
    return any(warning.startswith("the flights bend") for warning in result.warnings)


@pytest.mark.slow
def test_e_g_and_position_move_with_an_antenna_as_the_budget_says() -> None:
    fixed = {"rate_hz": 2500.0, "snr_db": 40.0, "skew_s": 0.0, "floor": 0.0, "wall": 0.0, "flicker": 0.0}
    record = make_record(draw_scene(9, "physical", "drop", drag=0.0, e=0.7, height_m=0.2, moving_s=0.5, **fixed))
    recording = record.recording
    joint = changed(record.setup, processing={"correction": "joint"}, floor={"normal": (0.0, 0.0, 1.0)})
    exact = dict.fromkeys(("u_tilt_deg", "u_azimuth_deg", "u_distance_m"), 0.0)
    plain = joint.model_dump(by_alias=True)
    for receiver in plain["receiver"]:
        receiver.update(exact)
    plain["transmitter"].update(u_distance_m=0.0, u_x_m=0.0, u_y_m=0.0)
    plain["tracer"]["u_release_m"] = 0.0
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
    # stated two of its u off: the flights tell where the antenna is, and results stay where they were
    there = process(recording, with_receiver(setup, tilt_deg=tilt + 2.0 * U_TILT_DEG))
    budget = here.uncertainty_budget
    assert budget is not None
    assert budget.assumed == {"tracer.u_diameter_m": 2e-5}
    by_key = {one.key: one for one in there.setup_posterior}
    found = by_key["receiver[1].tilt_deg"]
    assert found.u_found < 0.5 * U_TILT_DEG
    assert abs(found.found - tilt) < 3.0 * found.u_found
    assert found.pull == pytest.approx(-2.0, abs=1.0)
    assert here.track is not None
    assert there.track is not None
    assert here.segment is not None
    part = slice(here.segment.first, here.segment.last)
    moved = (there.track.position_m - here.track.position_m)[:, part]
    assert np.sqrt(np.nanmean(moved**2)) < 2.0 * (budget.position_m.calibration or 0.0)
    first, other = here.bounces.impacts[0], there.bounces.impacts[0]
    assert abs(other.e - first.e) < first.u_e_combined
    fall, later = here.bounces.free_fall, there.bounces.free_fall
    assert fall is not None
    assert later is not None
    assert abs(later.g_m_s2 - fall.g_m_s2) < 2.0 * (budget.g_m_s2.combined or 0.0)
    # the wrong antenna bends the flights: that is told where its uncertainty does not hold it
    sure = process(recording, with_receiver(setup, tilt_deg=tilt + U_TILT_DEG, u_tilt_deg=0.0))
    assert [told(one) for one in (here, there, sure)] == [False, False, True]


def test_what_a_single_phase_centre_leaves_of_horns_is_the_calibration_s_share() -> None:
    setup = make_record(draw_scene(9, "physical", "drop", moving_s=0.2, rate_hz=1000.0)).setup
    time_s = np.linspace(0.0, 0.2, 50)
    place = np.array([0.0 * time_s, 0.0 * time_s, 0.1 - 5.0 * time_s**2])
    track = Track(time_s, place, np.full((3, 50), 1e-5), np.ones(50, np.bool_), "exact")
    fall = FreeFall(9.81, 1e-3, 0.0, 0.2, 0.1, 0.2, (0.1, 0.0, -4.905), 1e-6)
    bounces = Bounces((Bounce(0.15, 1.5, 1.2, 0.8, 1e-4, "made", valid=True),), free_fall=fall)

    def shares(setup: Setup) -> tuple[float, float]:
        *_, budget = with_budget(track, bounces, (), Segment(0, 50, 0, 0), setup)
        assert budget.e.calibration in (None, 0.0)
        return 1e3 * (budget.position_m.calibration or 0.0), budget.g_m_s2.calibration or 0.0

    assert shares(setup) == (0.0, 0.0)
    one = with_receiver(setup, phase_centre_m=0.12)
    every = changed(one, transmitter={"phase_centre_m": 0.12})
    (one_mm, of_one), (every_mm, of_every) = shares(one), shares(every)
    # 0.08 mm of a path of which a place is about half
    assert 0.02 < one_mm < every_mm < 0.2
    # a fall of 0.2 m whose heights bend by 0.04 mm
    assert 1e-3 < of_one < of_every < 0.02
