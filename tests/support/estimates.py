"""Estimates of whole recordings: conditioned, rounds, joint, as `process` makes them one after the other."""

from __future__ import annotations

from radargui.conditioning.condition import condition
from radargui.conditioning.conditioned import Conditioned
from radargui.estimation.adaptive.found import AdaptiveRounds, adaptive_rounds
from radargui.estimation.joint import JointEstimate, estimate_joint
from radargui.model.recording import Recording
from radargui.model.setup import Setup


def conditioned_of(recording: Recording, setup: Setup) -> Conditioned:
    conditioned = condition(recording, setup)
    assert isinstance(conditioned, Conditioned)
    return conditioned


def rounds_of(recording: Recording, setup: Setup) -> AdaptiveRounds:
    return adaptive_rounds(conditioned_of(recording, setup), setup)


def joint_of(recording: Recording, setup: Setup) -> JointEstimate:
    return estimate_joint(rounds_of(recording, setup), setup)
