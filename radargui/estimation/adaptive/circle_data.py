"""Collect the data of a round of circle fits: places, channels at one time, known amplitudes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from radargui.estimation.adaptive.circle_fit import CircleData
from radargui.estimation.forward.bins import BinnedData, Bins
from radargui.estimation.forward.position_map import PositionBasis
from radargui.model.arrays import BoolArray, ComplexArray, FloatArray
from radargui.model.front_end import channels_of
from radargui.physics.path_length import MIN_RECEIVERS, Antennas, locate_exact, range_factor
from radargui.signals.ellipse import Ellipse

_MAX_TURN_RAD = 0.3  # of half a bin: 1/24 fringe turns 0.13; more is a phase that slipped


def map_places(change_m: FloatArray, antennas: Antennas, release_m: FloatArray, rest: BoolArray) -> FloatArray:
    """Return the coordinate of the maps: exact positions (3, n), or (L - L_rest) / 2 of one or two receivers.

    Parameters
    ----------
    change_m
        Shape (n_receivers, n).
    antennas, release_m
        Geometry.
    rest
        Bins in which the tracer still rests at the release position.
    """
    if antennas.n_receivers < MIN_RECEIVERS:
        place = change_m / 2.0
        place[:, rest] = 0.0
        return place
    place = locate_exact(change_m, antennas, release_m)
    # noise at rest would draw the maps, which are most certain there
    place[:, rest] = release_m[:, None]
    known = np.isfinite(place).all(axis=0)
    if not known.all():
        index = np.arange(known.size)
        place = np.array([np.interp(index, index[known], row[known]) for row in place])
    return place


def averaging_loss(phase_rad: FloatArray, bins: Bins) -> FloatArray:
    """Return cos(s dphi/dt), which averaging over a bin leaves of a turning wave, shape (..., n_bins)."""
    rate = np.gradient(phase_rad, bins.time_s, axis=-1)
    return np.asarray(np.cos(np.clip(rate * bins.node_s, -_MAX_TURN_RAD, _MAX_TURN_RAD)))


def circle_data(
    binned: BinnedData,
    value: FloatArray,
    phase_rad: FloatArray,
    place: FloatArray,
    bias: PositionBasis | None,
    amplitude_map: PositionBasis | None,
) -> list[CircleData]:
    """Return each receiver's bins with map functions and the known factor of the amplitude.

    Parameters
    ----------
    binned
        Data.
    value
        Means brought to the time of channel 0, shape (n_channels, n_bins).
    phase_rad, place
        Phases and places of the preceding round, shapes (n_receivers, n_bins) and (n_dimensions, n_bins).
    bias, amplitude_map
        Functions of the maps; None without maps.
    """
    bins, n_receivers = binned.bins, binned.antennas.n_receivers
    none, shape = np.zeros((bins.n_bins, 0)), averaging_loss(phase_rad, bins)
    if n_receivers >= MIN_RECEIVERS:  # else the position is unknown
        shape = range_factor(place, binned.antennas, binned.release_m) * shape
    at_bias = none if bias is None else np.asfortranarray(bias(place))
    at_amplitude = none if amplitude_map is None else np.asfortranarray(amplitude_map(place))
    return [
        CircleData(
            i=value[2 * n],
            q=value[2 * n + 1],
            sigma_i=bins.sigma[2 * n],
            sigma_q=bins.sigma[2 * n + 1],
            shape=shape[n],
            bias=at_bias,
            amplitude_map=at_amplitude,
        )
        for n in range(n_receivers)
    ]


def unit_phasor(angle_rad: FloatArray) -> ComplexArray:
    """Return exp(j angle), shape as the angle, in half of the time that the complex exponential takes."""
    return np.asarray(np.cos(angle_rad) + 1j * np.sin(angle_rad))


def at_one_time(
    binned: BinnedData, phase_rad: FloatArray, amplitude: FloatArray, ellipses: Sequence[Ellipse]
) -> FloatArray:
    """Return what each channel would have shown at the time of channel 0, shape (n_channels, n_bins).

    Channel k of a multiplexer shows Z(t + d_k). The difference A (exp(j phi(t)) - exp(j phi(t + d_k))), as the
    receiver's front end shows it, is added.

    Parameters
    ----------
    binned
        The means as measured, and the delays d_k.
    phase_rad, amplitude
        Current estimates, shape (n_receivers, n_bins).
    ellipses
        Constants of each receiver.
    """
    bins, delay_s = binned.bins, binned.delay_s
    value = bins.value.copy()
    if not delay_s.any():
        return value
    for receiver, ellipse in enumerate(ellipses):
        pair, own = slice(2 * receiver, 2 * receiver + 2), phase_rad[receiver]
        # from the phase, not from the samples: an interpolation of bins would be too coarse
        later = (np.interp(bins.time_s + delay, bins.time_s, own) for delay in delay_s[pair])
        now = unit_phasor(own)
        change_i, change_q = (amplitude[receiver] * (now - unit_phasor(after)) for after in later)
        value[pair] += channels_of(change_i, change_q, ellipse.gain_ratio, ellipse.quadrature_error_rad)
    return value
