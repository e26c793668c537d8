"""Values of conditioned signals laid back into the whole recording, with the sign that its wiring has."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.correction.ellipse import Ellipse
from radargui.correction.published import ChannelSteps, PublishedSteps
from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.corrected import CorrectedIQ
from radargui.model.front_end import FrontEnd
from radargui.model.path import PathLengths
from radargui.model.quality import ChannelQuality
from radargui.model.recording import Recording
from radargui.model.segment import Segment
from radargui.model.track import Track

_F = TypeVar("_F", FrontEnd, ChannelQuality)
_Values = TypeVar("_Values", FloatArray, BoolArray, IntArray)


class Whole:
    """Lays values of conditioned signals back into all samples of the recording; NaN and invalid outside.

    Corrected Q, its quality and its steps are shown beside the recorded Q: they get the wiring's sign back here, and
    only here. Path lengths and track have none.

    Parameters
    ----------
    recording
        Gives the number and the times of the samples.
    conditioned
        What the values were found in.
    receivers
        Which receivers of the recording these are, numbered from 0.
    """

    def __init__(self, recording: Recording, conditioned: Conditioned, receivers: Sequence[int]) -> None:
        self._time_s = recording.time_s()
        self._samples = conditioned.samples
        self._start = int(conditioned.samples.start)
        self._sign = conditioned.phase_sign
        self._receivers, self._n_receivers = list(receivers), recording.n_receivers

    def segment(self, segment: Segment) -> Segment:
        """Return the segment counted in samples of the recording."""
        return segment.counted_from(-self._start)

    def corrected(self, corrected: CorrectedIQ, faults: Sequence[str]) -> CorrectedIQ:
        """Return corrected IQ of all samples and receivers; those with a fault are rejected with it."""
        # all are faulty until the sound ones are laid over them
        channels = [ChannelQuality(str(k + 1), verdict="rejected", reason=why) for k, why in enumerate(faults)]
        steps: list[object] = [None] * self._n_receivers
        for place, channel in zip(self._receivers, corrected.channels, strict=True):
            channels[place] = replace(as_wired(channel, self._sign), name=str(place + 1))
        for place, step in zip(self._receivers, corrected.steps, strict=False):
            steps[place] = self._steps(step)
        return replace(
            corrected,
            time_s=self._time_s,
            i=self._all(corrected.i),
            q=self._sign * self._all(corrected.q),
            u_phase_rad=self._all(corrected.u_phase_rad),
            valid=self._all(corrected.valid),
            channels=tuple(channels),
            steps=tuple(steps) if corrected.steps else (),
        )

    def paths(self, paths: PathLengths) -> PathLengths:
        """Return path lengths of all samples."""
        phase_rad, change_m, u_m = (self._all(rows) for rows in (paths.phase_rad, paths.change_m, paths.u_m))
        piece = None if paths.piece is None else self._spread(paths.piece)
        return PathLengths(self._time_s, phase_rad, change_m, u_m, self._all(paths.valid), piece)

    def track(self, track: Track) -> Track:
        """Return the track of all samples."""
        return replace(
            track,
            time_s=self._time_s,
            position_m=self._spread(track.position_m),
            u_position_m=self._spread(track.u_position_m),
            valid=self._spread(track.valid),
            u_combined_m=None if track.u_combined_m is None else self._spread(track.u_combined_m),
        )

    def _steps(self, step: object) -> object:
        if isinstance(step, PublishedSteps):
            return PublishedSteps(self._channel(step.i, 1), self._channel(step.q, self._sign))
        if isinstance(step, Ellipse) and self._sign < 0:
            return replace(step, q0_v=-step.q0_v, quadrature_error_rad=-step.quadrature_error_rad)
        return step

    def _channel(self, steps: ChannelSteps, sign: int) -> ChannelSteps:
        peaks, valleys = steps.peaks + self._start, steps.valleys + self._start
        upper, lower = steps.upper, steps.lower
        # an inverted Q exchanges peaks and valleys
        if sign < 0:
            peaks, valleys, upper, lower = valleys, peaks, -lower, -upper
        return replace(
            steps,
            segment=self.segment(steps.segment),
            peaks=peaks,
            valleys=valleys,
            upper=upper,
            lower=lower,
            zero_crossings=steps.zero_crossings + self._start,
            bias=sign * self._spread(steps.bias),
            scale=self._spread(steps.scale),
        )

    def _all(self, rows: _Values) -> _Values:
        """Return rows of some receivers in some samples as rows of all in all."""
        rows = self._spread(rows)
        if len(self._receivers) == self._n_receivers:
            return rows
        out = _unknown((self._n_receivers, rows.shape[1]), rows)
        out[self._receivers] = rows
        return out

    def _spread(self, values: _Values) -> _Values:
        if values.shape[-1] == self._time_s.size:
            return values
        out = _unknown((*values.shape[:-1], self._time_s.size), values)
        out[..., self._samples] = values
        return out


def _unknown(shape: tuple[int, ...], like: _Values) -> _Values:
    """Return NaN, False or piece 0, as the type of `like` has it."""
    return np.full(shape, np.nan if like.dtype.kind == "f" else 0, dtype=like.dtype)


def as_wired(front_end: _F, phase_sign: int) -> _F:
    """Return a quadrature error found with Q inverted as that of Q as it is wired, and the other way round.

    Q = g A sin(phase + eps) with an inverted phase is -g A sin(phase - eps).
    """
    angle = front_end.quadrature_error_deg
    if phase_sign > 0 or angle is None:
        return front_end
    return replace(front_end, quadrature_error_deg=-angle)
