"""Check whether I and Q lie all around one ellipse.

Where a target goes to and fro within a frame this tells a pair of channels; spectra do not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, IntArray
from radargui.model.errors import ProcessingError
from radargui.signals.ellipse import Ellipse, fit_ellipse


@dataclass(frozen=True, slots=True)
class TurnSettings:
    """When samples count as lying all around one ellipse. Chosen by hand; figures are of laboratory records.

    Attributes
    ----------
    parts
        Number of parts of a turn. Each must be seen, for a conic fits every arc.
    min_in_part
        Least number of samples for a part to count as seen: single ones are noise.
    even
        Largest number of samples of a part that the ellipse is fitted to: a sphere that lies for seconds must not
        dominate the fit.
    max_off
        Root mean square of |z| - 1 beyond noise, each part counted alike: sound receivers over a floor have up to 0.17,
        I and Q of different receivers, motions or tones 0.24 and more.
    max_noise
        Largest noise, in amplitudes: with more the circle has no hole.
    gain, max_quadrature_deg
        Of the ellipse, either way: mixers here have up to 20 degrees, cables swapped before a short way 25.
    """

    parts: int = 16
    min_in_part: int = 3
    even: int = 64
    max_off: float = 0.18
    max_noise: float = 0.2
    gain: float = 2.0
    max_quadrature_deg: float = 23.0


SETTINGS = TurnSettings()


@dataclass(frozen=True, slots=True)
class Turn:
    """How samples lie on an ellipse.

    Attributes
    ----------
    is_whole
        Whether they lie on the ellipse of one echo behind a usual mixer, and all around it.
    is_arc
        Whether they lie on a part of an ellipse only, so that its shape is unknown.
    """

    is_whole: bool
    is_arc: bool


def turn_around_ellipse(pair_v: FloatArray, noise_v: FloatArray) -> Turn:
    """Return how I and Q lie on one ellipse.

    Parameters
    ----------
    pair_v
        I and Q in the motion, finite and not clipped, shape (2, n_samples).
    noise_v
        White noise of each, shape (2,).
    """
    try:
        ellipse = fit_ellipse(pair_v)
        # again with each part of the turn alike: where the sphere lies for seconds it would lead the conic
        for _ in range(2):
            ellipse = fit_ellipse(pair_v[:, _evenly(_part(ellipse.apply(pair_v)))])
    except ProcessingError:
        return Turn(is_whole=False, is_arc=False)
    iq = ellipse.apply(pair_v)
    is_seen = bool((np.bincount(_part(iq), minlength=SETTINGS.parts) >= SETTINGS.min_in_part).all())
    # two receivers or motions crossed lie on a figure that a conic fits only as no mixer has it
    is_mixer = 1.0 / SETTINGS.gain < ellipse.gain_ratio < SETTINGS.gain
    is_mixer &= abs(float(np.degrees(ellipse.quadrature_error_rad))) <= SETTINGS.max_quadrature_deg
    is_whole = is_mixer and is_whole_circle(iq, _noise(ellipse, noise_v))
    return Turn(is_whole=is_whole, is_arc=not is_seen)


def is_whole_circle(iq: FloatArray, noise: float) -> bool:
    """Whether corrected I and Q lie on the unit circle, and all around it.

    Parameters
    ----------
    iq
        In amplitudes, finite, shape (2, n_samples).
    noise
        White noise of I and of Q, in amplitudes.
    """
    if noise > SETTINGS.max_noise:
        return False
    part = _part(iq)
    count = np.bincount(part, minlength=SETTINGS.parts)
    if (count < SETTINGS.min_in_part).any():
        return False
    square = (np.hypot(iq[0], iq[1]) - 1.0) ** 2
    off = np.bincount(part, weights=square, minlength=SETTINGS.parts) / count
    # along the radius noise scatters like a mismatch: their squares add
    return bool(off.mean() - noise**2 < SETTINGS.max_off**2)


def _part(iq: FloatArray) -> IntArray:
    """Return the part of the turn that each sample lies in."""
    turn = np.arctan2(iq[1], iq[0]) / (2.0 * np.pi)
    return np.asarray(np.floor(turn * SETTINGS.parts).astype(np.intp) % SETTINGS.parts)


def _evenly(part: IntArray) -> IntArray:
    """Return places of samples of which every part has at most so many."""
    places = [np.flatnonzero(part == number) for number in range(SETTINGS.parts)]
    count = SETTINGS.even
    few = [one if one.size <= count else one[np.linspace(0, one.size - 1, count).astype(int)] for one in places]
    return np.concatenate(few)


def _noise(ellipse: Ellipse, noise_v: FloatArray) -> float:
    i, q = noise_v[0] / ellipse.amplitude_v, noise_v[1] / (ellipse.amplitude_v * ellipse.gain_ratio)
    return float(np.sqrt(0.5 * (i**2 + q**2)))
