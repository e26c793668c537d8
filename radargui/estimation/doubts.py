"""What a solution that fits its signals may be wrong in: mirrors not found, a place hardly known, a fringe.

Method 6, Hardly known.
"""

from collections.abc import Sequence

import numpy as np

from radargui.estimation.forward.parameters import polarisation_places
from radargui.estimation.forward.signal_model import complex_of
from radargui.estimation.motion_estimate import MotionEstimate
from radargui.estimation.select.loose_maps import bias_deviations, goes_beyond_wave
from radargui.estimation.solve.minimise import Solution
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.finding import Finding, warn
from radargui.model.result import Track
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import InputChange
from radargui.physics.path_length import LARGE_CONDITION, condition_number, place_antennas

_MAX_U_M = 1.5e-4
"""Uncertainty of a place, root mean square over the motion, above which it is reported: drops of 30 dB without a wall
that nobody can tell are known to 0.01 to 0.05 mm."""
_SURE_FRINGE_M = 1e-3
"""The same above which no fringe is sure: a lost one shifts a place by some mm. 22 dB on a shaken plate, 5 mm off, were
known to 3 mm; others whose spectra say as little, and that are right, to 0.01 to 0.1."""
_MAX_BIAS = 0.2
"""Deviation of bias maps, in amplitudes, above which they stand for what reflects: generic scenes have 0.01 to 0.07, a
level circle over a floor and beside a wall of which the search found neither 0.5."""
_COUNTED_HZ = 4000.0
"""Means a second that hold 2 kHz, in which a bouncing sphere moves."""
_COVERAGE = 2.0
"""Times what inputs off by their u give to bias maps, that these may have beside it: in 45 dB antennas known to half a
degree gave 0.40 and 0.52, and maps had 0.32 and 0.24."""
_MAX_WAVERING = 0.4
"""Deviation of maps of ln A, where nothing flies, above which they stand for it too: level motions that are right
within their u have up to 0.33, a pendulum that lost a fringe, 20 mm off, 0.5."""
_MAX_REFLECTION = 0.5
"""Share of the wave that no floor or wall sends back: 0.1 to 0.35 was found in 34 sound scenes of floors of 0.1 to 0.3,
0.8 in a level circle that is 2.2 mm off."""
_MAX_TURNED = 5.0
"""Deviations that a polarisation may be found off what the setup says: right setups had up to 3.3, azimuths mirrored or
counted clockwise 8.3 and 5.1, wires of two antennas exchanged 12."""
_MIN_U_DEG = 0.1
"""A polarisation that is known better is held by what the setup says."""
_MIN_SHOWN = 0.1
"""Share of a polarisation's variance that the signals have to take away: else nothing is known of it."""


def is_unknown(track: Track, onset_s: float, wavelength_m: float) -> bool:
    """Whether flights bend so much that u was widened beyond a wavelength: then not even the fringes are counted."""
    return _u_moving_m(track.u_position_m, track.time_s > onset_s) > wavelength_m


def is_fringe_sure(track: Track | None, onset_s: float) -> bool:
    """Whether places are known so well that the motion has shown which fringe each is."""
    return track is not None and _u_moving_m(track.u_position_m, track.time_s > onset_s) < _SURE_FRINGE_M


def _u_moving_m(u_position_m: FloatArray, moving: BoolArray) -> float:
    square = (u_position_m[:, moving] ** 2).sum(axis=0)
    return float(np.sqrt(np.nanmean(square))) if np.isfinite(square).any() else 0.0


def doubt(solution: Solution, onset_s: float, setup: Setup, by_setup: FloatArray | float = 0.0) -> Finding | None:
    """Return a finding where maps or mirrors stand for what no laboratory has, else None.

    Parameters
    ----------
    solution, onset_s, setup
        Converged; the end of the rest; what it was made with.
    by_setup
        Deviation, in amplitudes, that inputs off by their u give to the bias maps, (n_receivers,): where flights agree
        with the setup (`SetupResponses.bias_deviations`).
    """
    return missing_mirrors(solution, onset_s, setup, by_setup) or unlikely_mirrors(solution)


def missing_mirrors(
    solution: Solution, onset_s: float, setup: Setup, by_setup: FloatArray | float = 0.0
) -> Finding | None:
    """Return a finding where the maps of the offsets take what only mirrors or another count make, else None."""
    problem = solution.problem
    most = np.hypot(_MAX_BIAS, _COVERAGE * by_setup)
    # of a metal sphere that counts as a point they take what it scatters; the budget has that
    grown = setup.transmitter.polarization_deg is not None and (bias_deviations(solution) > most).any()
    beyond = goes_beyond_wave(solution, onset_s)
    wavers = max(float(problem.prior.sd[own.amplitude_map.start]) for own in problem.layout.receivers) > _MAX_WAVERING
    if not (grown or beyond or (wavers and not problem.in_flight.any())):
        return None
    return warn("wall_unseen", what="offsets" if grown or beyond else "amplitude")


def unlikely_mirrors(solution: Solution) -> Finding | None:
    """Return a finding where mirrors that no laboratory has stand for a motion that no flight holds, else None."""
    problem, theta = solution.problem, solution.state.theta
    layout = problem.layout
    if problem.in_flight.any() or not problem.inputs.planes:
        return None
    places = [layout.transmitter_reflection, *(own.receiver_reflection for own in layout.receivers)]
    most = max(float(np.abs(complex_of(theta[own])).max()) for own in places)
    if most < _MAX_REFLECTION:
        return None
    return warn("mirror_too_strong", share=most)


def turned_polarisation(solution: Solution) -> Finding | None:
    """Return a finding where the sphere scatters as it cannot with the polarisations of the setup, else None.

    Of a Gaussian with the prior deviation s, found by d with the deviation u left: d has the variance s^2 - u^2, where
    the setup is right. Azimuths that are mirrored, or all turned, bend no flight: against the transmitter's field they
    show.

    Parameters
    ----------
    solution
        Converged.
    """
    layout, prior = solution.problem.layout, solution.problem.prior
    if solution.problem.sphere is None:
        return None
    places = polarisation_places(layout)
    off, square = solution.state.theta[places] - prior.mean[places], prior.sd[places] ** 2
    shown = 1.0 - solution.normal.global_variances()[places] / square
    # what the setup calls exact is held
    held = (shown < _MIN_SHOWN) | (square < np.radians(_MIN_U_DEG) ** 2)
    turned = np.where(held, 0.0, off / np.sqrt(square * np.maximum(shown, _MIN_SHOWN)))
    worst = int(np.argmax(np.abs(turned)))
    if abs(turned[worst]) < _MAX_TURNED:
        return None
    antenna = f"receiver[{worst}]" if worst else "transmitter"
    by_deg = float(np.degrees(off[worst] / shown[worst]))
    return warn("polarization_off", antenna=antenna, by_deg=by_deg, deviations=float(abs(turned[worst])))


def _noise_of_path_m(estimate: MotionEstimate, wavelength_m: float) -> float:
    """Return what white noise makes of the path length of the weakest receiver within 2 kHz, in m."""
    share = max((10.0 ** (-one.snr_db / 20.0) for one in estimate.channels if one.snr_db is not None), default=0.0)
    within = min(1.0, _COUNTED_HZ * float(estimate.time_s[1] - estimate.time_s[0]))
    return wavelength_m / (2.0 * np.pi) * share * float(np.sqrt(0.5 * within))


def hardly_known(estimate: MotionEstimate, setup: Setup, changes: Sequence[InputChange] | None) -> Finding | None:
    """Return a finding where the motion is known much worse than noise and the setup let it be, else None."""
    if estimate.u_position_m is None:
        return None
    u_m = _u_moving_m(estimate.u_position_m, estimate.time_s > estimate.onset_s)
    # antennas known to a degree make millimetres, and their mirrors as much: the budget says so
    square = sum(_u_moving_m(one.moved_m, one.time_s > estimate.onset_s) ** 2 for one in changes or ())
    if u_m < max(_MAX_U_M, float(np.sqrt(square))):
        return None
    because = "noise" if _noise_of_path_m(estimate, setup.radar.wavelength_m) > u_m else "reflectors"
    grows = condition_number(place_antennas(setup))
    if grows > LARGE_CONDITION:
        because = "antennas"
    is_point = because == "reflectors" and setup.transmitter.polarization_deg is None
    return warn("position_hardly_known", u_m=u_m, because=because, grows=grows, is_point=is_point)
