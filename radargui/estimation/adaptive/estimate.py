"""The adaptive estimate of one to four receivers, each on its own circle."""

from __future__ import annotations

import numpy as np

from radargui.estimation.adaptive.found import AdaptiveRounds
from radargui.estimation.adaptive.samples import circles_at_samples
from radargui.estimation.motion_estimate import MotionEstimate, channel_qualities
from radargui.estimation.signals import composed
from radargui.model.front_end import FrontEnd
from radargui.physics.path_length import MIN_RECEIVERS, locate_exact, position_uncertainty


def estimate_adaptive(found: AdaptiveRounds) -> MotionEstimate:
    """Correct each receiver by a circle whose centre and radius are functions of position.

    Parameters
    ----------
    found
        The rounds of one to four receivers; positions need three.
    """
    signals, data, last = found.signals, found.data, found.last
    samples = circles_at_samples(found, signals)
    # bistatic: a turn of the phase is a wavelength of the whole path, there and back, not half of one
    change = samples.phase_rad * data.wavelength_m / (2.0 * np.pi)
    u_change = samples.u_phase_rad * data.wavelength_m / (2.0 * np.pi)
    rest = signals.time_s < found.signals.rest_end_s
    # the rest is where paths count from: its noise is no motion
    change[:, rest] = 0.0
    position = u_position = None
    if data.antennas.n_receivers >= MIN_RECEIVERS:
        # three paths meet in two places: the bins know in which of them the tracer is
        start = np.array([np.interp(signals.time_s, data.bins.time_s, row) for row in last.place])
        position = locate_exact(change, data.antennas, data.release_m, start)
        u_position = position_uncertainty(position, u_change, data.antennas)
    constants = composed([_constants(found, n) for n in range(data.antennas.n_receivers)], signals)
    chi_square = np.array([fit.chi_square for fit in last.fits])
    valid = signals.valid & np.isfinite(change)
    channels = channel_qualities(
        signals,
        ~rest,
        (samples.i, samples.q),
        valid,
        samples.phase_rad,
        np.median(last.amplitude, axis=1),
        data.bins.typical_sigma,
        chi_square,
        constants,
    )
    return MotionEstimate(
        "adaptive",
        signals.time_s,
        change,
        u_change,
        samples.i,
        samples.q,
        valid,
        position,
        u_position,
        found.signals.onset_s,
        found.impact_s,
        constants,
        channels,
        chi_square,
        _choices(found),
    )


def _constants(found: AdaptiveRounds, receiver: int) -> FrontEnd:
    fit = found.last.fits[receiver]
    # Birge: residuals above the noise widen, those below by chance do not narrow
    u = np.sqrt(np.diag(fit.covariance) * max(1.0, fit.chi_square))
    at, ellipse = fit.layout, fit.ellipse
    return FrontEnd(
        gain_ratio=ellipse.gain_ratio,
        u_gain_ratio=ellipse.gain_ratio * float(u[at.log_gain]),
        quadrature_error_deg=float(np.degrees(ellipse.quadrature_error_rad)),
        u_quadrature_error_deg=float(np.degrees(u[at.quadrature_error])),
    )


def _choices(found: AdaptiveRounds) -> tuple[str, ...]:
    if found.last.bias is None:
        return ()
    where = "position" if found.data.antennas.n_receivers >= MIN_RECEIVERS else "path length"
    return (f"Maps of {where} with a correlation length of {found.last.bias.length_m:.2f} m.",)
