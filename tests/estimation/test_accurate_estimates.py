"""Adaptive and joint estimates on seeded scenes with known truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.scene import SceneRecord, make_record
from support.estimates import exactly_known, joint_of, rounds_of

from radargui.estimation.adaptive.estimate import estimate_adaptive
from radargui.estimation.adaptive.found import AdaptiveRounds
from radargui.estimation.joint import JointEstimate, estimate_joint
from radargui.model.errors import CancelledError, ProcessingError
from radargui.restitution.joint_bounces import joint_bounces
from radargui.signals.condition import condition
from radargui.signals.stretch import NoMotion


def noise_bound_m(record: SceneRecord) -> float:
    scene = record.scene
    ratio = 10.0 ** (-scene.snr_db / 20.0) / np.sqrt(2.0) * np.sqrt(min(1.0, 4000.0 / scene.rate_hz))
    return float(scene.setup.radar.wavelength_m / (2.0 * np.pi) * ratio)


def moving(record: SceneRecord, time: np.ndarray) -> np.ndarray:
    return time > record.scene.motion.motion_start_s


def rms_3d_m(record: SceneRecord, estimate) -> float:
    error = (estimate.position_m - record.truth.position_m)[:, moving(record, estimate.time_s)]
    return float(np.sqrt((error**2).sum(axis=0).mean()))


@pytest.fixture(scope="module")
def drop() -> SceneRecord:
    return make_record(draw_scene(9, "generic", "drop", rate_hz=5000.0, snr_db=35.0, skew_s=2e-5, e=0.7, height_m=0.2))


@pytest.fixture(scope="module")
def rounds(drop: SceneRecord) -> AdaptiveRounds:
    return rounds_of(drop.recording, drop.setup)


@pytest.fixture(scope="module")
def joint(drop: SceneRecord, rounds: AdaptiveRounds) -> JointEstimate:
    return estimate_joint(rounds, drop.setup)


def test_corrected_iq_lies_on_the_unit_circle_and_hardware_is_found(
    drop: SceneRecord, joint: JointEstimate, rounds: AdaptiveRounds
) -> None:
    for estimate in (joint, estimate_adaptive(rounds)):
        for n, (own, true) in enumerate(zip(estimate.constants, drop.scene.receiving, strict=True)):
            assert own.gain_ratio == pytest.approx(true.gain, rel=0.005)
            assert own.quadrature_error_deg == pytest.approx(np.degrees(true.quadrature_rad), abs=0.3)
            radius = np.hypot(estimate.i[n], estimate.q[n])
            assert radius == pytest.approx(1.0, abs=0.12)
            assert estimate.channels[n].verdict == "good"


def test_a_floor_that_reflects_is_kept_by_the_evidence() -> None:
    record = make_record(
        draw_scene(
            3,
            "physical",
            "drop",
            rate_hz=2000.0,
            snr_db=35.0,
            wall=0.0,
            flicker=0.0,
            drag=0.03,
            floor=0.2,
            moving_s=0.5,
        )
    )
    setup = exactly_known(record.setup)
    estimate = joint_of(record.recording, setup)
    assert "floor that reflects is kept" in estimate.choices[0]
    assert rms_3d_m(record, estimate) < 5e-5
    _, fit = joint_bounces(estimate, setup)
    assert fit is not None
    assert fit.drag_1_m == pytest.approx(0.03, abs=0.005)


@pytest.mark.parametrize(("motion", "moving_s"), [("circle", 0.7), ("bed", 0.4)])
def test_no_impact_is_invented(motion: str, moving_s: float) -> None:
    scene = draw_scene(8, "generic", motion, rate_hz=2000.0, snr_db=35.0, n_receivers=3, moving_s=moving_s)
    record = make_record(scene)
    estimate = joint_of(record.recording, record.setup)
    assert estimate.impact_s.size == 0
    assert rms_3d_m(record, estimate) < 1e-4


@pytest.mark.parametrize("n_receivers", [1, 2, 4])
def test_adaptive_reaches_the_noise_bound_with_any_number_of_receivers(n_receivers: int) -> None:
    record = make_record(
        draw_scene(
            6, "generic", "drop", n_receivers=n_receivers, rate_hz=10000.0, snr_db=28.0, skew_s=1e-5, drift_m_s=0.0
        )
    )
    estimate = estimate_adaptive(rounds_of(record.recording, record.setup))
    error = (estimate.change_m - (record.truth.path_m - record.truth.path_m[:, :1]))[:, moving(record, estimate.time_s)]
    assert np.sqrt((error**2).mean()) < 2.5 * noise_bound_m(record)
    in_u = error / estimate.u_change_m[:, moving(record, estimate.time_s)]
    # 0.36, 0.12 (maps of the path alone, lateral motion) and 0.75: neither too small nor of another order
    assert 0.1 < np.sqrt((in_u**2).mean()) < 1.0
    assert (np.abs(in_u) < 2.0).mean() > 0.95
    assert (estimate.position_m is None) == (n_receivers < 3)


def test_joint_refuses_two_receivers_no_motion_and_stops_when_asked(drop: SceneRecord, rounds: AdaptiveRounds) -> None:
    two = make_record(draw_scene(6, "generic", "drop", n_receivers=2, rate_hz=2000.0, skew_s=0.0))
    with pytest.raises(ProcessingError, match="three receivers"):
        joint_of(two.recording, two.setup)
    count = int(0.15 * drop.scene.rate_hz)
    nothing_moves = condition(replace(drop.recording, raw=drop.recording.raw[:, :count]), drop.setup)
    assert isinstance(nothing_moves, NoMotion)
    told: list[float] = []

    def enough(share: float) -> None:
        told.append(share)
        if len(told) == 3:
            raise CancelledError

    with pytest.raises(CancelledError):
        estimate_joint(rounds, drop.setup, progress=enough)
    assert 0.0 < told[0] < told[1] < told[2] < 1.0
