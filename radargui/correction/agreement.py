"""Compare a corrected path with the echo that was followed without a correction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, runs_of

if TYPE_CHECKING:
    # loads what only one or two receivers need
    from radargui.signals.echo import Echo


@dataclass(frozen=True, slots=True)
class AgreementSettings:
    """When a path counts as agreeing with the echo. Chosen by hand; `bench robust` is the test (decision 20).

    Attributes
    ----------
    block_s, blocks
        Path and echo are compared within blocks of `block_s` and over these numbers of blocks. A target of 5 Hz turns
        by a third of a radian in the shortest span and by three turns in the longest, so that a path that stands still
        is noticed.
    max_rad, share
        Largest change of their difference within a block and to the next one: an absolute part (0.2 wavelengths, by
        which an offset of two thirds of the amplitude bends a path) and a share of the phase turned.
    """

    block_s: float = 0.01
    blocks: tuple[int, ...] = (4, 16, 64)
    max_rad: float = 1.2
    share: float = 0.08


AGREEMENT = AgreementSettings()


def strays(phase_rad: FloatArray, valid: BoolArray, echo: Echo, sample_rate_hz: float) -> BoolArray:
    """Return where a phase turns differently from an echo that is trusted there, shape (n_samples,).

    Parameters
    ----------
    phase_rad, valid
        Of one receiver, unwrapped, shape (n_samples,).
    echo
        Of the same receiver.
    sample_rate_hz
        Of the samples.
    """
    size = max(4, round(AGREEMENT.block_s * sample_rate_hz))
    count = -(-phase_rad.size // size)
    both = valid & echo.leads & np.isfinite(phase_rad)

    def blocks(values: FloatArray, outside: float) -> FloatArray:
        filled = np.full(count * size, outside)
        filled[: values.size] = np.where(both, values, outside)
        return filled.reshape(count, size)

    # a difference of phases: their common zero is not known, only changes count
    away = np.where(both, phase_rad, 0.0) - echo.phase_rad
    low, high = blocks(away, np.inf).min(axis=1), blocks(away, -np.inf).max(axis=1)
    seen = np.isfinite(low)
    middle = np.where(seen, 0.5 * (np.where(seen, low, 0.0) + np.where(seen, high, 0.0)), np.nan)
    # the front end of either bends the phase by a share of what it turns
    turned = blocks(echo.phase_rad, -np.inf).max(axis=1) - blocks(echo.phase_rad, np.inf).min(axis=1)
    allowed = AGREEMENT.max_rad + AGREEMENT.share * np.where(seen, turned, 0.0)
    apart = seen & (np.where(seen, high - low, 0.0) > allowed)
    # a hole between two blocks: nothing is claimed over it
    with np.errstate(invalid="ignore"):
        stepped = np.abs(np.diff(middle)) > np.minimum(allowed[1:], allowed[:-1])
    apart[1:] |= stepped
    apart[:-1] |= stepped
    for length in AGREEMENT.blocks:
        whole = count // length * length
        # over a hole a path starts anew, and a fringe that was lost has been found in the short blocks
        led = (seen & ~apart)[:whole].reshape(-1, length).all(axis=1)
        spread = high[:whole].reshape(-1, length).max(axis=1) - low[:whole].reshape(-1, length).min(axis=1)
        turns = turned[:whole].reshape(-1, length).sum(axis=1)
        far = led & (np.where(led, spread, 0.0) > AGREEMENT.max_rad + AGREEMENT.share * np.where(led, turns, 0.0))
        apart[:whole] |= np.repeat(far, length)
    return np.asarray(np.repeat(apart, size)[: phase_rad.size])


def lasting(stray: BoolArray, phase_rad: FloatArray, valid: BoolArray, echo: Echo) -> BoolArray:
    """Return the differences of `strays` that last.

    Where the phase returns to the echo, the low-pass has only rounded an impact.

    A lost fringe never comes back. Parameters as in `strays`.
    """
    out, known = stray.copy(), np.flatnonzero(valid & echo.leads & ~stray)
    away = phase_rad - echo.phase_rad
    for begin, end in runs_of(stray):
        before, after = known[known < begin], known[known >= end]
        if before.size and after.size:
            out[begin:end] = abs(away[after[0]] - away[before[-1]]) > AGREEMENT.max_rad
    return out
