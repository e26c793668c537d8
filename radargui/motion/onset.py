"""Onset: the time when the tracer leaves its rest."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray

_BLOCK_S = 0.005
_REST_S = 0.1
_THRESHOLD = 6.0
_MOST_WANDER = 0.02
_SHORTEST_REST_S = 0.05
_DRIFT_REST_S = 0.2
_DRIFT_DEGREE = 2


def find_onset(time_s: FloatArray, value: FloatArray) -> float | None:
    """Return the time of the last block that still looks like the rest, None where nothing moves.

    Means over 5 ms are compared with the mean of the first 0.1 s; the tracer moves where two blocks in turn differ by
    more than 6 standard deviations of the rest's blocks in the root mean square over the channels.

    Parameters
    ----------
    time_s
        Shape (n_samples,).
    value
        Shape (n_channels, n_samples).

    Returns
    -------
    float or None
        -inf where the record starts in motion (less than 50 ms of rest).
    """
    label = ((time_s - time_s[0]) / _BLOCK_S).astype(np.intp)
    first = np.flatnonzero(np.diff(label, prepend=-1))
    count = np.diff(np.append(first, label.size))
    mean = np.add.reduceat(value, first, axis=1) / count
    start = time_s[first]
    rest = start < time_s[0] + _REST_S
    if rest.sum() < 8:
        return float("-inf")
    white = (
        np.median(np.abs(np.diff(value[:, : count[0] * int(rest.sum())], axis=1)), axis=1) / 0.95 / np.sqrt(count[0])
    )
    scale = np.median(value.std(axis=1))
    size = np.clip(mean[:, rest].std(axis=1), white, np.maximum(white, _MOST_WANDER * scale)) + 1e-12
    distance = np.sqrt((((mean - mean[:, rest].mean(axis=1)[:, None]) / size[:, None]) ** 2).mean(axis=0))
    away = distance > _THRESHOLD
    lasting = np.flatnonzero(away[:-1] & away[1:])
    if lasting.size == 0:
        return None
    onset = float(start[lasting[0]])
    return onset if onset > time_s[0] + _SHORTEST_REST_S else float("-inf")


def without_rest_drift(time_s: FloatArray, value: FloatArray, rest_last: int) -> FloatArray:
    """Return the channels less the parabola that their offsets follow at rest, so that a drift is no onset.

    Parameters
    ----------
    time_s
        Shape (n_samples,).
    value
        Shape (n_channels, n_samples).
    rest_last
        Samples before this one are at rest for sure; under 0.2 s of them the channels are left as they are.
    """
    if rest_last < 8 or time_s[rest_last - 1] - time_s[0] < _DRIFT_REST_S:
        return value
    pooled = max(1, rest_last // 200)
    count = rest_last // pooled
    means = value[:, : count * pooled].reshape(value.shape[0], count, pooled).mean(axis=2)
    middle = time_s[: count * pooled].reshape(count, pooled).mean(axis=1) - time_s[0]
    trend = np.polynomial.polynomial.polyfit(middle, means.T, _DRIFT_DEGREE)
    trend[0] = 0.0
    return np.asarray(value - np.polynomial.polynomial.polyval(time_s - time_s[0], trend))
