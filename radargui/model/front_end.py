"""A receiver's front end: the hardware part of its mismatch, constant for a session."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True, slots=True)
class FrontEnd:
    """Constants of one receiver's front end with standard uncertainties.

    Attributes
    ----------
    gain_ratio, u_gain_ratio
        Amplitude of Q over amplitude of I.
    quadrature_error_deg, u_quadrature_error_deg
        Departure of Q from 90 degrees after I.
    """

    gain_ratio: float
    u_gain_ratio: float
    quadrature_error_deg: float
    u_quadrature_error_deg: float

    def after(self, first: FrontEnd) -> FrontEnd:
        """Return the constants of what was taken off first and of these, which were found in what was left.

        Q / g0 = sin e0 X + cos e0 Y', Y' = g1 (sin e1 X + cos e1 Y): together Q = a X + b Y.
        """
        e0, e1 = np.radians(first.quadrature_error_deg), np.radians(self.quadrature_error_deg)
        # quadrature errors do not simply add: the second one is seen through the first
        along = first.gain_ratio * (np.sin(e0) + np.cos(e0) * self.gain_ratio * np.sin(e1))
        across = first.gain_ratio * np.cos(e0) * self.gain_ratio * np.cos(e1)
        return self._turned(along, across, first.gain_ratio)

    def with_change_since(self, before: FrontEnd, u_log_gain: float) -> FrontEnd:
        """Return the same, uncertain also by five times what it has changed by, and by another share of the gain ratio.

        Rounds of which each changes a fifth less than the one before would still change it by four times that.
        """
        return replace(
            self,
            u_gain_ratio=float(
                np.linalg.norm(
                    [self.u_gain_ratio, 5.0 * (self.gain_ratio - before.gain_ratio), self.gain_ratio * u_log_gain]
                )
            ),
            u_quadrature_error_deg=float(
                np.hypot(self.u_quadrature_error_deg, 5.0 * (self.quadrature_error_deg - before.quadrature_error_deg))
            ),
        )

    def less(self, first: FrontEnd) -> FrontEnd:
        """Return what is left of these constants where others are taken off first: the inverse of `after`."""
        e0, e = np.radians(first.quadrature_error_deg), np.radians(self.quadrature_error_deg)
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
        Whether the run was estimated with it: not where it contradicts it, nor where it knows as much by itself.
    """

    runs: tuple[str, ...]
    front_ends: tuple[FrontEnd, ...]
    used: bool = True
