"""The analogue front end of a receiver: its two constants and its equations in both directions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray

Channel = TypeVar("Channel", FloatArray, ComplexArray)


@dataclass(frozen=True, slots=True)
class FrontEnd:
    """Constants of one receiver's front end with standard uncertainties.

    Attributes
    ----------
    gain_ratio, u_gain_ratio
        Amplitude of Q over amplitude of I.
    quadrature_error_deg, u_quadrature_error_deg
        Departure of Q from 90 degrees after I.
    harmonics, u_harmonics
        What a mixer makes of the echo that turns at -3 and +3 times its phase, over the echo: real and imaginary parts
        by turns, four numbers; none where they are not known.
    """

    gain_ratio: float
    u_gain_ratio: float
    quadrature_error_deg: float
    u_quadrature_error_deg: float
    harmonics: tuple[float, ...] = ()
    u_harmonics: tuple[float, ...] = ()

    @property
    def quadrature_error_rad(self) -> float:
        """Quadrature error in rad."""
        return float(np.radians(self.quadrature_error_deg))

    def with_phase_sign(self, phase_sign: int) -> FrontEnd:
        """Return the constants of the signals that `with_phase_sign` makes of these; its own inverse, too.

        Q = g A sin(phase + eps) with an inverted phase is -g A sin(phase - eps); harmonics become their conjugates.
        """
        turned = tuple(one * (phase_sign if part % 2 else 1) for part, one in enumerate(self.harmonics))
        return replace(self, quadrature_error_deg=phase_sign * self.quadrature_error_deg, harmonics=turned)

    def after(self, first: FrontEnd) -> FrontEnd:
        """Return the constants of what was taken off first and of these, which were found in what was left.

        Q / g0 = sin e0 X + cos e0 Y', Y' = g1 (sin e1 X + cos e1 Y): together Q = a X + b Y.
        """
        e0, e1 = first.quadrature_error_rad, self.quadrature_error_rad
        # quadrature errors do not simply add: the second one is seen through the first
        along = first.gain_ratio * (np.sin(e0) + np.cos(e0) * self.gain_ratio * np.sin(e1))
        across = first.gain_ratio * np.cos(e0) * self.gain_ratio * np.cos(e1)
        return self._turned(along, across, first.gain_ratio)

    def with_change_since(self, before: FrontEnd, u_log_gain: float) -> FrontEnd:
        """Return the same constants with u widened by five times their change, and by a share of the gain ratio.

        If each round changes a fifth less than the one before, later rounds change it by four times the last change.
        """
        gain, angle = self.gain_ratio - before.gain_ratio, self.quadrature_error_deg - before.quadrature_error_deg
        u_gain_ratio = np.linalg.norm([self.u_gain_ratio, 5.0 * gain, self.gain_ratio * u_log_gain])
        u_angle = np.hypot(self.u_quadrature_error_deg, 5.0 * angle)
        return replace(self, u_gain_ratio=float(u_gain_ratio), u_quadrature_error_deg=float(u_angle))

    def less(self, first: FrontEnd) -> FrontEnd:
        """Return the constants that remain after others are taken off: the inverse of `after`."""
        e0, e = first.quadrature_error_rad, self.quadrature_error_rad
        # Q of the first is taken off before: what is left is a shear and a stretch of the same kind
        share = self.gain_ratio / first.gain_ratio
        along, across = (share * np.sin(e) - np.sin(e0)) / np.cos(e0), share * np.cos(e) / np.cos(e0)
        return self._turned(along, across, 1.0 / first.gain_ratio)

    def _turned(self, along: float, across: float, share: float) -> FrontEnd:
        """Return the constants of Q = along X + across Y; their uncertainties are those of these, the gain's scaled."""
        error_deg, u_gain_ratio = float(np.degrees(np.arctan2(along, across))), share * self.u_gain_ratio
        gain_ratio = float(np.hypot(along, across))
        return replace(self, gain_ratio=gain_ratio, u_gain_ratio=u_gain_ratio, quadrature_error_deg=error_deg)


@dataclass(frozen=True, slots=True)
class FrontEndPrior:
    """What earlier runs of a session say about the front ends, as prior of a run.

    Attributes
    ----------
    runs
        Names of the runs.
    front_ends
        One a receiver.
    used
        Whether the run was estimated with it. It is not used if the run contradicts it or knows as much by itself.
    """

    runs: tuple[str, ...]
    front_ends: tuple[FrontEnd, ...]
    used: bool = True


def run_names(runs: tuple[str, ...]) -> str:
    """Return runs as people read them: run-0001 to run-0003."""
    return runs[0] if len(runs) == 1 else f"{runs[0]} to {runs[-1]}"


def with_phase_sign(volts: FloatArray, phase_sign: int) -> FloatArray:
    """Return I1, Q1, I2, ... with Q negated where the wiring inverts it, a new array then.

    In the returned signals a longer path turns every phase forward; all measurements start from them. The function is
    its own inverse.

    Parameters
    ----------
    volts
        Shape (2 n_receivers, ...).
    phase_sign
        `Radar.phase_sign`.
    """
    if phase_sign > 0:
        return volts
    out = volts.copy()
    out[1::2] *= -1.0
    return out


def channels_of(
    z_of_i: ComplexArray, z_of_q: ComplexArray, gain_ratio: float, quadrature_error_rad: float
) -> FloatArray:
    """Return what the two channels show of Z, without offsets, shape (2, ...).

    Parameters
    ----------
    z_of_i, z_of_q
        Z when I is sampled and when Q is: a multiplexer takes them one after the other. Shape (...).
    gain_ratio
        g, amplitude of Q over amplitude of I.
    quadrature_error_rad
        eps, departure of Q from 90 degrees after I.
    """
    sine, cosine = np.sin(quadrature_error_rad), np.cos(quadrature_error_rad)
    return np.stack([z_of_i.real, gain_ratio * (sine * z_of_q.real + cosine * z_of_q.imag)])


def channel_factors(gain_ratio: FloatArray, quadrature_error_rad: FloatArray) -> ComplexArray:
    """Return h = (1, g (sin eps - j cos eps)), shape (..., 2): I and Q show Re h Z, as `channels_of` says.

    The slope of Q by eps is -Im h Z.

    Parameters
    ----------
    gain_ratio, quadrature_error_rad
        As in `channels_of`, shape (...).
    """
    q = gain_ratio * (np.sin(quadrature_error_rad) - 1j * np.cos(quadrature_error_rad))
    return np.stack([np.ones_like(q), q], axis=-1)


def noise_across(
    noise_i: FloatArray, noise_q: FloatArray, gain_ratio: float, quadrature_error_rad: float
) -> FloatArray:
    """Return the standard deviation of Y of `point_of` where I and Q have noise of their own, shape as theirs.

    The noise of X is that of I. Parameters as in `point_of`.
    """
    # Y is made of Q and of a share of X: their noises add in squares
    own, shared = noise_q / gain_ratio, noise_i * np.sin(quadrature_error_rad)
    return np.asarray(np.hypot(own, shared) / np.cos(quadrature_error_rad))


def point_of(i: Channel, q: Channel, gain_ratio: float, quadrature_error_rad: float) -> Channel:
    """Return X = Re Z and Y = Im Z of channels without offsets, the inverse of `channels_of`, shape (2, ...).

    X = I, Y = (Q / g - X sin eps) / cos eps.

    Parameters
    ----------
    i, q
        Offsets taken off, at the same instant, or their spectra, shape (...).
    gain_ratio, quadrature_error_rad
        As in `channels_of`.
    """
    out: Channel = np.empty((2, *i.shape), dtype=i.dtype)
    # Q leans towards I by eps: its share of X is taken off before it is stretched back
    out[0], out[1] = i, (q / gain_ratio - i * np.sin(quadrature_error_rad)) / np.cos(quadrature_error_rad)
    return out


def slopes_of_point(
    x: FloatArray, y: FloatArray, gain_ratio: float, quadrature_error_rad: float
) -> tuple[float, float, FloatArray, FloatArray]:
    """Return the derivatives of Y of `point_of` by the offsets of I and of Q, by ln g and by eps.

    X depends on the offset of I only, with the derivative -1.

    Parameters
    ----------
    x, y
        The point, shape (n,).
    gain_ratio, quadrature_error_rad
        As in `channels_of`.
    """
    tangent = float(np.tan(quadrature_error_rad))
    by_q = -1.0 / (gain_ratio * float(np.cos(quadrature_error_rad)))
    return tangent, by_q, -(y + x * tangent), y * tangent - x
