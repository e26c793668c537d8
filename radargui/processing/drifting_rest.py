"""Whether all paths grow while the tracer hangs at rest: an oscillator that drifts, or a tracer that sinks.

Method 8, An oscillator that drifts.
"""

import numpy as np

from radargui.model.arrays import BoolArray, ComplexArray, FloatArray
from radargui.model.finding import Finding, warn
from radargui.model.result import Segment

_LEAST_M_S = 5e-5
"""Of a path: half of it is a speed, a part in 50 000 of a fall's."""
_SIGMAS = 6.0
"""Of white noise: 1/f noise makes more of a drift, but not in all receivers alike."""
_ALIKE = 0.3
"""The slowest path over the fastest, and a radius over its path: offsets drift in any direction, one a receiver."""
_PATH_M = 1.4
"""From an antenna over the sphere to another, usually: a frequency that drifts by a share makes that share of it."""


def drifting_rest(
    time_s: FloatArray, point: ComplexArray, valid: BoolArray, segment: Segment, wavelength_m: float
) -> Finding | None:
    """Return a finding where all paths grow, or shrink, alike before the motion, else None.

    Each rest lies next to one point of the unit circle: what turns it is a path, what lengthens it is none.

    Parameters
    ----------
    time_s
        Of the samples, shape (n,).
    point, valid
        I + jQ on the unit circle, by an estimate that has no say in what rests (the joint one has the tracer at its
        place then), and what is known of it, shapes (n_receivers, n).
    segment
        The rest.
    wavelength_m
        Of the transmitted wave.
    """
    rest = slice(segment.rest_first, segment.rest_last)
    found = np.array([_slopes(time_s[rest], *one) for one in zip(point[:, rest], valid[:, rest], strict=True)])
    # NaN compares false
    speed, radial, u = found.T * wavelength_m / (2.0 * np.pi)
    size = np.abs(speed)
    alike = bool(size.min() > _ALIKE * size.max()) and abs(float(np.sign(speed).sum())) == speed.size
    if not (alike and (size > np.maximum(_SIGMAS * u, _LEAST_M_S)).all() and (np.abs(radial) < _ALIKE * size).all()):
        return None
    mean = float(speed.mean())
    return warn("rest_drifts", speed_m_s=mean, share_per_s=abs(mean) / _PATH_M)


def _slopes(time_s: FloatArray, point: ComplexArray, valid: BoolArray) -> FloatArray:
    """Return by what a receiver's phase and radius change in a second at rest, and the u of both, in rad and radii."""
    known = valid & np.isfinite(point)
    if known.sum() < 3:
        return np.full(3, np.nan)
    point = point[known] / point[known].mean()
    away_s = time_s[known] - time_s[known].mean()
    square = float(away_s @ away_s)
    slope = (away_s @ point) / square
    off = point - point.mean() - slope * away_s
    u = np.sqrt(float((np.abs(off) ** 2).mean()) / 2.0 / square)
    return np.array([slope.imag, slope.real, u])
