"""Recognise a fall in the signals alone, by how the phases turn when the sphere moves along the vertical."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, runs_of
from radargui.model.gravity import fall_speed_m_s, fall_time_s
from radargui.model.setup import Setup
from radargui.physics.path_length import path_gradient, place_antennas

RATE_HZ = 2000.0
"""Of the means: a fall of 1 m ends at 300 Hz of Doppler at 10 GHz. Chosen by hand; faster, differences are noise."""
WINDOW_M = 1.103625e-3
"""Way of a fall from rest in half a window: 30 ms on Earth, in which a fall bends the phase by 0.5 rad at 10 GHz. By
hand: shorter, noise hides it; longer, falls are missed."""
ACCELERATION = (0.6, 1.45)
"""Allowed share of the acceleration expected at the release: it changes as the sphere comes nearer to the floor."""
MIN_SPEED_M = 4.587e-3
"""Way of a fall from rest to the least speed, 0.3 m/s on Earth; slower, noise hides which way the phase turns."""
LARGEST_MISFIT_RAD = 0.4
"""Root mean square about the parabola. Chosen by hand: less, and weak receivers see no fall; more, and noise passes."""


@dataclass(frozen=True, slots=True)
class VerticalMotion:
    """The motion along the vertical that phases show, a value for each receiver and window.

    Windows are one sample apart.

    Attributes
    ----------
    speed_m_s, times_g
        Downward speed, and downward acceleration divided by g, in the middle of the window.
    fits
        Whether the phase follows a parabola, as it does under a constant acceleration.
    """

    speed_m_s: FloatArray
    times_g: FloatArray
    fits: BoolArray


def window_of(rate_hz: float, gravity_m_s2: float, half_m: float = WINDOW_M) -> int:
    """Return the number of samples of a window; in half of it a fall from rest covers a given distance."""
    return max(6, round(2.0 * fall_time_s(half_m, gravity_m_s2) * rate_hz))


def min_speed_m_s(gravity_m_s2: float) -> float:
    """Return the speed along the fall below which a window says nothing."""
    return fall_speed_m_s(MIN_SPEED_M, gravity_m_s2)


def turning_phases(volts: FloatArray, rate_hz: float) -> FloatArray:
    """Return angles (n_receivers, n - 2) that turn as the phases do while the motion goes one way.

    Offsets do not matter. The voltages are I1, Q1, I2, ..., shape (2 n_receivers, n).
    """
    # the derivative has no offset: no ellipse is needed to tell how it turns
    slope = (volts[:, 2:] - volts[:, :-2]) * (0.5 * rate_hz)
    return np.unwrap(np.arctan2(slope[1::2], slope[::2]))


def vertical_motion(
    phase: FloatArray, rate_hz: float, window: int, rad_per_m: FloatArray, gravity_m_s2: float
) -> VerticalMotion:
    """Return what parabolas through the phases of receivers say of the vertical, shapes (n_receivers, n - window + 1).

    Parameters
    ----------
    phase
        Shape (n_receivers, n), at least a window of them.
    rate_hz
        Of the phases.
    window
        How many of them a parabola goes through.
    rad_per_m
        Change of each phase for a metre of fall, shape (n_receivers, 1).
    gravity_m_s2
        Of the place, in which the acceleration is told.
    """
    time = (np.arange(window) - 0.5 * (window - 1)) / rate_hz
    basis = np.stack([np.ones(window), time, time**2 - np.mean(time**2)])
    found = []
    for one in phase:
        windows = np.lib.stride_tricks.sliding_window_view(one, window)
        weights = windows @ basis.T / (basis**2).sum(axis=1)
        power = np.mean(windows**2, axis=1) - weights**2 @ np.mean(basis**2, axis=1)
        found.append((weights[:, 1], 2.0 * weights[:, 2], np.sqrt(np.maximum(power, 0.0))))
    speed, bend, misfit = np.stack(found, axis=1)
    fits = np.asarray(misfit < LARGEST_MISFIT_RAD)
    return VerticalMotion(speed / rad_per_m, bend / (rad_per_m * gravity_m_s2), fits)


def radians_fallen(setup: Setup) -> FloatArray:
    """Return by how much each phase, signs aside, grows for a metre of fall from the release, (n_receivers, 1)."""
    release = np.array(setup.tracer.release_position_m)[:, None]
    along = -path_gradient(release, place_antennas(setup))[:, 2, 0]
    return np.asarray(2.0 * np.pi / setup.radar.wavelength_m * along)[:, None]


def longest_run(where: BoolArray) -> int:
    """Return how many in turn are True at the most."""
    return int(np.diff(runs_of(where)).max(initial=0))
