"""The quality of one IQ pair.

Intervals in which one receiver shows what no motion explains: a loose contact, a dip of its supply.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

from radargui.model.finding import Finding, refuse


@dataclass(frozen=True, slots=True)
class ChannelQuality:
    """Quality of one IQ pair; None where the signal cannot support the figure.

    Attributes
    ----------
    name
        Receiver, "1" to "4".
    snr_db
        10 log10(A^2 / (2 sigma^2)), sigma the noise of one channel.
    circularity
        Root mean square of abs(z) - 1 after correction, in amplitudes.
    image_rejection_db
        20 log10 of the line at +f_doppler over the line at -f_doppler of I + iQ after correction.
    fringes
        Turns of the phase used.
    fraction_valid
        Share of valid samples in the motion segment.
    fraction_clipped
        Share of samples that are clipped or left out (an open contact, milliseconds that no motion explains).
    gain_ratio
        Amplitude of Q over amplitude of I.
    quadrature_error_deg
        Departure of Q from 90 degrees after I.
    finding
        Why the receiver is not good; the finding refuses it, or warns of a usable one.
    u_gain_ratio, u_quadrature_error_deg
        Standard uncertainties of gain ratio and quadrature error.
    harmonics, u_harmonics
        As of `FrontEnd`.
    prior_runs
        Runs of the session whose gain ratio and quadrature error were the prior of these; empty where none was used.
    """

    name: str
    snr_db: float | None = None
    circularity: float | None = None
    image_rejection_db: float | None = None
    fringes: float | None = None
    fraction_valid: float | None = None
    fraction_clipped: float | None = None
    gain_ratio: float | None = None
    quadrature_error_deg: float | None = None
    finding: Finding | None = None
    u_gain_ratio: float | None = None
    u_quadrature_error_deg: float | None = None
    prior_runs: tuple[str, ...] = ()
    harmonics: tuple[float, ...] = ()
    u_harmonics: tuple[float, ...] = ()

    @property
    def verdict(self) -> str:
        """Whether it is good, usable or rejected."""
        if self.finding is None:
            return "good"
        return "rejected" if self.finding.severity == "refuse" else "usable"

    @property
    def reason(self) -> str:
        """Why, when not good, in words."""
        return "" if self.finding is None else self.finding.text

    def document(self) -> dict[str, object]:
        """Return what JSON holds of it, its verdict and reason in words."""
        out = {one.name: getattr(self, one.name) for one in fields(self) if one.name != "finding"}
        return {**out, "verdict": self.verdict, "reason": self.reason}


@dataclass(frozen=True, slots=True)
class UnexplainedStretch:
    """Where a receiver, numbered from 0, shows what no motion of the body does."""

    receiver: int
    begin_s: float
    end_s: float


def unexplained_of(stretches: Sequence[UnexplainedStretch]) -> dict[int, Finding]:
    """Return the finding of each receiver that has stretches; the receivers are numbered from 0, in order."""
    return {
        receiver: refuse(
            "dip_unexplained",
            spans=tuple(f"{begin:.3f} to {end:.3f}" for begin, end in _joined(stretches, receiver)),
        )
        for receiver in sorted({one.receiver for one in stretches})
    }


def _joined(stretches: Sequence[UnexplainedStretch], receiver: int) -> list[tuple[float, float]]:
    """Return from when to when the stretches of a receiver go; those that overlap are one."""
    out: list[tuple[float, float]] = []
    for begin, end in sorted((one.begin_s, one.end_s) for one in stretches if one.receiver == receiver):
        if out and begin <= out[-1][1]:
            out[-1] = out[-1][0], max(end, out[-1][1])
        else:
            out.append((begin, end))
    return out
