"""The road of estimators that hold motion and mismatch together: adaptive, and joint with adaptive as its fallback."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from radargui.correction.adaptive.estimate import estimate_adaptive
from radargui.correction.adaptive.found import Found, adaptive_rounds
from radargui.correction.estimate import MotionEstimate
from radargui.correction.hardware import disagreement, knows_more
from radargui.correction.joint.estimate import JointEstimate, estimate_joint
from radargui.correction.quality import image_rejection_db
from radargui.geometry.antennas import place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.corrected import CorrectedIQ
from radargui.model.errors import ProcessingError
from radargui.model.front_end import FrontEnd, FrontEndPrior
from radargui.model.path import PathLengths
from radargui.model.recording import Recording
from radargui.model.segment import Segment
from radargui.model.setup import Setup
from radargui.model.track import Track
from radargui.processing.locate import LEAST_RECEIVERS, locate
from radargui.processing.road import Road
from radargui.restitution.flight_shift import FlightShift
from radargui.restitution.joint_bounces import joint_bounces


def estimated(
    recording: Recording,
    segment: Segment,
    setup: Setup,
    method: str,
    tell: Callable[[float], None],
    standing: Callable[[Road], None] | None = None,
    prior: FrontEndPrior | None = None,
) -> Road:
    """Return corrected IQ, path lengths and track by the joint or the adaptive estimate.

    Where the joint estimate does not fit the signal the adaptive one stands, and a warning says so. Fewer receivers
    than it needs are no fault of the run: then only who named the joint correction in the setup is told.

    Parameters
    ----------
    recording
        Without gaps.
    segment
        The motion in it and the rest before.
    setup
        Geometry, phase sign, release position, floor.
    method
        adaptive or joint.
    tell
        Called with the share done, 0 to 1; what it raises ends the work.
    standing
        Given the adaptive road before the joint estimate is begun.
    prior
        What is known about the front ends. The joint estimate is made without it, and again with it where the run by
        itself does not contradict it and knows much less: short drops.

    Raises
    ------
    ProcessingError
        Neither estimate can be made.
    """
    if method == "joint" and recording.n_receivers < LEAST_RECEIVERS:
        method = "adaptive"
        why = "it needs three receivers" if "correction" in setup.processing.model_fields_set else ""
    else:
        why = ""
    # the matrices are many and small: threads of the linear algebra cost four times what they save
    with threadpool_limits(limits=1, user_api="blas"):
        found, road = adaptive_rounds(recording, setup), None
        if method == "joint":
            if standing is not None:
                road = _road(estimate_adaptive(recording, setup, found), segment, setup)
                standing(road)
            joint, why, tried = _try_joint_with(prior, recording, setup, found, tell)
            if joint is not None:
                return _with_prior(_road(joint, segment, setup), tried, why)
        if road is None:
            road = _road(estimate_adaptive(recording, setup, found), segment, setup)
    warnings = (f"the joint correction does not stand here ({why}): the adaptive one was used",) if why else ()
    return replace(road, warnings=road.warnings + warnings)


def _road(estimate: MotionEstimate, segment: Segment, setup: Setup) -> Road:
    paths = _paths(estimate, setup)
    bounces, shift = None, None
    warnings: tuple[str, ...] = ()
    if isinstance(estimate, JointEstimate) and setup.processing.geometry == "exact":
        try:
            bounces, fit = joint_bounces(estimate, setup)
            shift = None if fit is None else FlightShift(fit, np.asarray(bounces.normal))
        except (np.linalg.LinAlgError, FloatingPointError, ValueError) as error:
            warnings = (f"the flights could not be fitted ({error}): the bounces were taken from the track",)
    return Road(
        _corrected(estimate, segment, setup), paths, _track(estimate, paths, setup), bounces, shift, warnings=warnings
    )


def _try_joint_with(
    prior: FrontEndPrior | None, recording: Recording, setup: Setup, found: Found, tell: Callable[[float], None]
) -> tuple[JointEstimate | None, str, FrontEndPrior | None]:
    """Return the joint estimate, why it does not stand or why its prior was not used, and the prior with its use."""
    joint, why = _try_joint(recording, setup, found, tell)
    if prior is None:
        return joint, why, None
    unused = replace(prior, used=False)
    if joint is not None:
        why = disagreement(joint.constants, prior.front_ends)
        if why or not knows_more(prior.front_ends, joint.constants):
            return joint, why, unused
    helped, failed = _try_joint(recording, setup, found, lambda _: tell(1.0), prior.front_ends)
    if helped is None:
        return joint, failed if joint is not None else why, unused
    return helped, "", replace(prior, used=True)


def _with_prior(road: Road, prior: FrontEndPrior | None, why: str) -> Road:
    """Return the road that tells which runs its prior came from, or why it was not used."""
    if prior is None:
        return road
    if prior.used:
        channels = tuple(replace(channel, prior_runs=prior.runs) for channel in road.corrected.channels)
        return replace(road, corrected=replace(road.corrected, channels=channels), front_end_prior=prior)
    if not why:
        return replace(road, front_end_prior=prior)
    runs = prior.runs[0] if len(prior.runs) == 1 else f"{prior.runs[0]} to {prior.runs[-1]}"
    warning = f"what {runs} say about the front ends is not used: this run does not agree ({why})"
    return replace(road, front_end_prior=prior, warnings=(*road.warnings, warning))


def _try_joint(
    recording: Recording,
    setup: Setup,
    found: Found,
    tell: Callable[[float], None],
    front_ends: tuple[FrontEnd, ...] | None = None,
) -> tuple[JointEstimate | None, str]:
    """Return the joint estimate, or None and why it does not stand."""
    try:
        joint = estimate_joint(recording, setup, found=found, hardware=front_ends, progress=tell)
    except ProcessingError as error:
        return None, error.message.rstrip(".")
    except (np.linalg.LinAlgError, FloatingPointError, ValueError) as error:
        return None, f"its equations have no solution: {error}"
    if not joint.fits:
        misfit = ", ".join(f"{value:.1f}" for value in joint.chi_square)
        return None, f"its misfit (chi-square {misfit}) is too large"
    return joint, ""


def _per_rad(setup: Setup) -> float:
    return setup.radar.wavelength_m / (2.0 * np.pi)


def _corrected(estimate: MotionEstimate, segment: Segment, setup: Setup) -> CorrectedIQ:
    moving = slice(segment.first, segment.last)
    phase = estimate.change_m[:, moving] / _per_rad(setup)
    channels = tuple(
        replace(channel, image_rejection_db=_image_rejection(estimate, number, moving, phase[number]))
        for number, channel in enumerate(estimate.channels)
    )
    return CorrectedIQ(
        estimate.time_s,
        estimate.i,
        estimate.q,
        estimate.valid,
        estimate.u_change_m / _per_rad(setup),
        estimate.method,
        channels,
    )


def _image_rejection(estimate: MotionEstimate, number: int, moving: slice, phase_rad: FloatArray) -> float | None:
    iq = np.stack([estimate.i[number, moving], estimate.q[number, moving]])
    known = bool(np.isfinite(iq).all() and np.isfinite(phase_rad).all())
    return image_rejection_db(iq, phase_rad) if known else None


def _paths(estimate: MotionEstimate, setup: Setup) -> PathLengths:
    return PathLengths(
        estimate.time_s, estimate.change_m / _per_rad(setup), estimate.change_m, estimate.u_change_m, estimate.valid
    )


def _track(estimate: MotionEstimate, paths: PathLengths, setup: Setup) -> Track | None:
    if estimate.position_m is None or estimate.u_position_m is None or setup.processing.geometry == "plane":
        release = np.array(setup.tracer.release_position_m)
        return locate(paths, place_antennas(setup), release, setup.processing.geometry)
    valid = np.asarray(estimate.valid.all(axis=0) & np.isfinite(estimate.position_m).all(axis=0))
    return Track(estimate.time_s, estimate.position_m, estimate.u_position_m, valid, "exact")
