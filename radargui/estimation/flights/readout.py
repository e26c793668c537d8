"""A drop at every sample: places, paths, corrected I and Q, and their uncertainties (method 6)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from radargui.estimation.flights.drop_model import wave_gain
from radargui.estimation.flights.estimate import DropEstimate
from radargui.estimation.forward.signal_model import shown, turn_of
from radargui.estimation.motion_estimate import MotionEstimate, channel_qualities
from radargui.estimation.signals import ScaledSignals, composed
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.front_end import FrontEnd, point_of
from radargui.model.result import Kinematics
from radargui.motion.flights import Flights
from radargui.physics.path_length import path_gradient, path_lengths

INSTANTS = 400
"""At which uncertainties are computed: between them they lie on straight lines."""
MIN_U_M = 1e-7
"""No place is known better: what the equations of the scattering leave out."""


class PlaceChanges(NamedTuple):
    """What places and paths change by with the unknowns at some instants.

    Attributes
    ----------
    time_s
        Shape (n,).
    place
        Shape (n_unknowns, 3, n).
    path
        Of the changes of path since the rest, shape (n_unknowns, n_receivers, n).
    """

    time_s: FloatArray
    place: FloatArray
    path: FloatArray


def place_changes(estimate: DropEstimate) -> PlaceChanges:
    """Return the derivatives of places and paths by the unknowns, at instants evenly over the drop."""
    model, flights = estimate.model, estimate.flights
    begin_s = min(float(model.bins.time_s[0]), flights.onset_s)
    time_s = np.linspace(begin_s, estimate.end_s, INSTANTS)
    position, by_flights = flights.position_and_slopes(time_s)
    place = estimate.by_unknowns(np.moveaxis(by_flights, 0, -1))
    antennas = model.setup.antennas(estimate.at.values.setup)
    gradient, at_rest = path_gradient(position, antennas), path_gradient(flights.start_m[:, None], antennas)
    path = np.einsum("ran,anu->rnu", gradient, place) - np.einsum("ra,anu->rnu", at_rest[..., 0], place[:, :1])
    # a path changes with its antennas too
    columns = np.zeros((*path.shape[:2], model.free.size))
    first = model.stated.start
    for receiver, by_place in enumerate(model.setup.receiver_slopes(estimate.at.values.setup)):
        for point, part, turn in (
            (antennas.transmitter_m, slice(first, first + 3), np.eye(3)),
            (antennas.receivers_m[receiver], slice(first + 3 + 3 * receiver, first + 6 + 3 * receiver), by_place),
        ):
            away, rest = (point[:, None] - where for where in (position, flights.start_m[:, None]))
            change = away / np.linalg.norm(away, axis=0) - rest / np.linalg.norm(rest, axis=0)
            columns[receiver, :, part] = change.T @ turn
    path = path + model.by_unknowns(columns)
    return PlaceChanges(time_s, np.moveaxis(place, -1, 0), np.moveaxis(path, -1, 0))


def drop_motion(estimate: DropEstimate, signals: ScaledSignals, changes: PlaceChanges) -> MotionEstimate:
    """Return the motion at the samples; what follows the last flight is not known.

    Standard uncertainties of places hold the setup; those of paths are all that is left open.
    """
    model, flights, time_s = estimate.model, estimate.flights, signals.time_s
    antennas = model.setup.antennas(estimate.at.values.setup)
    position = flights.position_m(time_s)
    change = path_lengths(position, antennas) - path_lengths(flights.start_m[:, None], antennas)
    place, path = changes.place, changes.path
    statistical, whole = estimate.widening**2 * estimate.held, estimate.widening**2 * estimate.covariance
    u_place = _spread(np.einsum("uan,uv,van->an", place, statistical, place), changes.time_s, time_s)
    u_path = _spread(np.einsum("urn,uv,vrn->rn", path, whole, path), changes.time_s, time_s)
    known = np.asarray((time_s <= estimate.end_s) & signals.usable)
    i, q, amplitude = _corrected(estimate, signals, change)
    valid = np.repeat(known[None], signals.n_receivers, axis=0)
    constants = composed(_constants(estimate), signals)
    chi_square = np.asarray(model.noise**2)
    channels = channel_qualities(
        signals,
        (time_s >= flights.onset_s) & (time_s <= estimate.end_s),
        (i, q),
        valid,
        change * model.setup.wavenumber(estimate.at.values.setup),
        amplitude,
        model.bins.typical_sigma,
        chi_square,
        constants,
    )
    # the last flight goes on in numbers only
    ended = time_s > estimate.end_s
    change, i, q, position = (np.where(ended, np.nan, values) for values in (change, i, q, position))
    return MotionEstimate(
        "flights",
        time_s,
        change,
        u_path,
        i,
        q,
        valid,
        position,
        u_place,
        flights.onset_s,
        flights.impact_s,
        constants,
        channels,
        chi_square,
        estimate.choices(),
    )


def drop_kinematics(estimate: DropEstimate, time_s: FloatArray) -> Kinematics:
    """Return place, velocity and acceleration at times (n,); uncertainties hold the setup."""
    flights = estimate.flights
    position, by_place = flights.position_and_slopes(time_s)
    velocity, by_velocity = flights.velocity_and_slopes(time_s)
    number = flights.number_at(time_s)
    flies = number >= 0
    acceleration = np.where(flies, flights.acceleration(velocity), 0.0)
    by_acceleration = np.where(flies, flights.acceleration_slopes(velocity, by_velocity), 0.0)
    u_m, u_m_s, u_m_s2 = (_u(estimate, slopes) for slopes in (by_place, by_velocity, by_acceleration))
    return Kinematics(time_s, position, velocity, acceleration, np.hypot(u_m, MIN_U_M), u_m_s, u_m_s2, number)


def _u(estimate: DropEstimate, by_flights: FloatArray) -> FloatArray:
    """Return what is known with the setup held of values by their slopes by the flights, (n_flights_values, 3, n)."""
    columns = estimate.by_unknowns(np.moveaxis(by_flights, 0, -1))
    variance = np.einsum("anu,uv,anv->an", columns, estimate.widening**2 * estimate.held, columns)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


def _spread(variance: FloatArray, known_s: FloatArray, time_s: FloatArray) -> FloatArray:
    """Return standard uncertainties at times from variances (k, n_known) at others."""
    u = np.sqrt(np.maximum(variance, 0.0) + MIN_U_M**2)
    return np.array([np.interp(time_s, known_s, row) for row in u])


def _constants(estimate: DropEstimate) -> tuple[FrontEnd, ...]:
    model, theta, out = estimate.model, estimate.at.values.theta, []
    u = estimate.widening * np.sqrt(np.diag(estimate.covariance))
    every = np.zeros(model.free.size)
    every[model.free] = u[len(model.setup.directions) :]
    of_theta = every[model.stated.stop :] * model.deviation.theta
    for own in model.layout.receivers:
        gain = float(np.exp(theta[own.log_gain]))
        angle, u_angle = np.degrees([theta[own.quadrature_error], of_theta[own.quadrature_error]]).tolist()
        out.append(FrontEnd(gain, gain * float(of_theta[own.log_gain]), angle, u_angle))
    return tuple(out)


def _corrected(
    estimate: DropEstimate, signals: ScaledSignals, change_m: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return I and Q on the unit circle at the time of channel 0, and the typical amplitude of each receiver.

    The circle of the direct path plus what the samples add to the model, brought back through front end and amplitude.
    """
    model, at, time_s = estimate.model, estimate.at, signals.time_s
    wavenumber, bin_s = model.setup.wavenumber(at.values.setup), model.bins.time_s
    antennas = model.setup.antennas(at.values.setup)
    flights = Flights.of(at.values.flights)
    rest_m = path_lengths(flights.start_m[:, None], antennas)
    values = model.layout.own_values(at.values.theta, slice(None))
    turn = turn_of(values, model.layout.own)[..., None]
    # of the mean wave of a bin's two channels, front end off
    whole = (shown(at.waves) * wave_gain(model, at)[:, 0, 0, :, 0] / turn).mean(axis=1)
    at_bins = path_lengths(flights.position_m(bin_s), antennas) - rest_m
    ratio = whole * np.exp(-1j * wavenumber * at_bins)
    besides = at.value - (shown(at.waves) * wave_gain(model, at)[:, 0, 0, :, 0]).real
    out_i, out_q = np.empty((2, *change_m.shape))
    for receiver in range(model.n_receivers):
        amplitude = _between(time_s, bin_s, ratio[receiver])
        left = []
        for channel in (0, 1):
            delay = float(model.delay_s[2 * receiver + channel])
            place = flights.position_m(time_s + delay)
            path = path_lengths(place, antennas)[receiver] - rest_m[receiver]
            wave = turn[receiver, channel] * amplitude * np.exp(1j * wavenumber * path)
            slow = np.interp(time_s, bin_s, besides[receiver, channel])
            left.append(signals.value[2 * receiver + channel] - wave.real - slow)
        gain = float(np.exp(values[receiver, model.layout.own.log_gain]))
        x, y = point_of(left[0], left[1], gain, float(values[receiver, model.layout.own.quadrature_error]))
        z = np.exp(1j * wavenumber * change_m[receiver]) + (x + 1j * y) / amplitude
        out_i[receiver], out_q[receiver] = z.real, z.imag
    return out_i, out_q, np.asarray(np.median(np.abs(whole), axis=1))


def _between(time_s: FloatArray, known_s: FloatArray, values: ComplexArray) -> ComplexArray:
    return np.asarray(np.interp(time_s, known_s, values.real) + 1j * np.interp(time_s, known_s, values.imag))
