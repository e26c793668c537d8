"""A receiver's front end: the hardware part of its mismatch, constant for a session."""

from __future__ import annotations

from dataclasses import dataclass


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
