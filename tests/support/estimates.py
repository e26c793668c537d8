"""Estimates of whole recordings: conditioned, rounds, joint, as `process` makes them one after the other."""

from __future__ import annotations

from radargui.estimation.adaptive.found import AdaptiveRounds, adaptive_rounds
from radargui.estimation.joint import JointEstimate, estimate_joint
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.signals.condition import condition
from radargui.signals.conditioned import Conditioned


def conditioned_of(recording: Recording, setup: Setup) -> Conditioned:
    conditioned = condition(recording, setup)
    assert isinstance(conditioned, Conditioned)
    return conditioned


def rounds_of(recording: Recording, setup: Setup) -> AdaptiveRounds:
    return adaptive_rounds(conditioned_of(recording, setup), setup)


def joint_of(recording: Recording, setup: Setup) -> JointEstimate:
    return estimate_joint(rounds_of(recording, setup), setup)


def exactly_known(setup: Setup) -> Setup:
    """Return a setup that calls antennas, release and wavelength exact: a truth that is as stated leaves only noise."""
    tables = setup.model_dump(by_alias=True, exclude_unset=True)
    tables["radar"] |= {"u_frequency_hz": 0.0}
    tables["transmitter"] |= {"u_distance_m": 0.0, "u_x_m": 0.0, "u_y_m": 0.0}
    exact = {"u_tilt_deg": 0.0, "u_azimuth_deg": 0.0, "u_distance_m": 0.0}
    tables["receiver"] = [{**one, **exact} for one in tables["receiver"]]
    tables["tracer"] = {**tables.get("tracer", {}), "u_release_m": 0.0}
    return Setup.model_validate(tables)
