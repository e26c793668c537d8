"""Values of conditioned signals laid back into the whole recording, with the sign that its wiring has."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from radargui.correction.published import ChannelSteps, PublishedSteps
from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.channel_quality import ChannelQuality
from radargui.model.finding import Finding
from radargui.model.recording import Recording
from radargui.model.result import CorrectedIQ, PathLengths, Segment, Track
from radargui.signals.conditioned import Conditioned
from radargui.signals.ellipse import Ellipse

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
        self._recording = recording
        self._samples, self._size = conditioned.samples, conditioned.size
        self._start, self._n_band = int(conditioned.samples.start), conditioned.n_samples
        rest = self.segment(conditioned.segment)
        self._rest = slice(rest.rest_first, rest.rest_last)
        self._sign = conditioned.phase_sign
        self._receivers, self._n_receivers = list(receivers), recording.n_receivers

    def segment(self, segment: Segment) -> Segment:
        """Return the segment counted in samples of the recording."""
        stored = [self._stored(edge) for edge in (segment.first, segment.last, segment.rest_first, segment.rest_last)]
        return Segment(*stored)

    def channels(self, corrected: CorrectedIQ, faults: Sequence[Finding | None]) -> tuple[ChannelQuality, ...]:
        """Return the quality of all receivers; those with a fault are rejected with it."""
        # all are faulty until the sound ones are laid over them
        channels = [ChannelQuality(str(k + 1), finding=why) for k, why in enumerate(faults)]
        for place, channel in zip(self._receivers, corrected.channels, strict=True):
            # of a sample as it was recorded: a mean of several has less noise
            snr_db = None if channel.snr_db is None else channel.snr_db - 10.0 * float(np.log10(self._size))
            error_deg = channel.quadrature_error_deg
            error_deg = None if error_deg is None else self._sign * error_deg
            channels[place] = replace(channel, name=str(place + 1), snr_db=snr_db, quadrature_error_deg=error_deg)
        return tuple(channels)

    def corrected(self, corrected: CorrectedIQ, channels: tuple[ChannelQuality, ...]) -> CorrectedIQ:
        """Return corrected IQ of all samples and receivers, with the quality of all."""
        rows = {name: self._all(getattr(corrected, name)) for name in ("i", "q", "u_phase_rad", "valid")}
        rows["q"] = self._sign * rows["q"]
        time_s, steps = self._recording.time_s(), self.steps(corrected.steps)
        return replace(corrected, time_s=time_s, channels=channels, steps=steps, **rows)

    def steps(self, found: Sequence[object]) -> tuple[object, ...]:
        """Return what the correction found on its way in samples of the recording, one a receiver; none where none."""
        steps: list[object] = [None] * self._n_receivers
        for place, step in zip(self._receivers, found, strict=False):
            steps[place] = self._steps(step)
        return tuple(steps) if found else ()

    def paths(self, paths: PathLengths) -> PathLengths:
        """Return path lengths of all samples."""
        phase_rad, change_m, u_m = (self._all(rows) for rows in (paths.phase_rad, paths.change_m, paths.u_m))
        piece, valid = None if paths.piece is None else self._spread(paths.piece), self._all(paths.valid)
        has_rest = self._rest.stop > self._rest.start
        if self._size > 1 and has_rest:
            # the lines between means leave the rest before its end does: its mean is the zero in the samples too
            for rows in (phase_rad, change_m):
                rows -= np.nan_to_num(rows[:, self._rest].mean(axis=1, keepdims=True))
        elif piece is None and not has_rest:
            # counted from the first mean or bin of what begins in motion: its first sample lies half of it before
            first = np.argmax(valid, axis=1)[:, None]
            for rows in (phase_rad, change_m):
                rows -= np.nan_to_num(np.take_along_axis(rows, first, axis=1))
        return PathLengths(self._recording.time_s(), phase_rad, change_m, u_m, valid, piece)

    def track(self, track: Track) -> Track:
        """Return the track of all samples."""
        rows = {name: getattr(track, name) for name in ("position_m", "u_position_m", "valid", "u_combined_m")}
        spread = {name: self._spread(own) for name, own in rows.items() if own is not None}
        return replace(track, time_s=self._recording.time_s(), **spread)

    def _steps(self, step: object) -> object:
        if isinstance(step, PublishedSteps):
            return PublishedSteps(self._channel(step.i, 1), self._channel(step.q, self._sign))
        if isinstance(step, Ellipse) and self._sign < 0:
            return replace(step, q0_v=-step.q0_v, quadrature_error_rad=-step.quadrature_error_rad)
        return step

    def _channel(self, steps: ChannelSteps, sign: int) -> ChannelSteps:
        middle = self._start + self._size // 2
        peaks, valleys, crossings = (
            middle + self._size * place for place in (steps.peaks, steps.valleys, steps.zero_crossings)
        )
        upper, lower = (self._in_segment(values, steps.segment) for values in (steps.upper, steps.lower))
        # an inverted Q exchanges peaks and valleys
        if sign < 0:
            peaks, valleys, upper, lower = valleys, peaks, -lower, -upper
        segment, bias, scale = self.segment(steps.segment), sign * self._spread(steps.bias), self._spread(steps.scale)
        return ChannelSteps(segment, peaks, valleys, upper, lower, bias, crossings, scale)

    def _all(self, rows: _Values) -> _Values:
        """Return rows of some receivers in some samples as rows of all in all."""
        rows = self._spread(rows)
        if len(self._receivers) == self._n_receivers:
            return rows
        out = np.full((self._n_receivers, rows.shape[1]), _unknown(rows), dtype=rows.dtype)
        out[self._receivers] = rows
        return out

    def _in_segment(self, values: FloatArray, segment: Segment) -> FloatArray:
        whole = np.full(self._n_band, np.nan)
        whole[segment.first : segment.last] = values
        first, last = self._stored(segment.first), self._stored(segment.last)
        return self._spread(whole)[first:last]

    def _stored(self, edge: int) -> int:
        """Return the stored sample at which a sample of the band begins; the last ends where its stretch does."""
        return int(self._samples.stop) if edge == self._n_band else self._start + self._size * edge

    def _spread(self, values: _Values) -> _Values:
        count, inside = self._recording.n_samples, self._samples
        if values.shape[-1] == count and self._size == 1:
            return values
        out = np.empty((*values.shape[:-1], count), dtype=values.dtype)
        for outside in (out[..., : inside.start], out[..., inside.stop :]):
            outside[...] = _unknown(values)
        interpolate(values, self._size, out[..., inside])
        return out


def interpolate(values: NDArray[Any], size: int, out: NDArray[Any]) -> None:
    """Write values (..., n), means of `size` samples each, to the samples, (..., n_samples), along straight lines.

    Between samples of the band a path bends by a t^2 / 8, far below its noise. Beyond the middles of the first and the
    last mean their line goes on. What is no number counts only where it holds on both sides.
    """
    if size == 1 or values.shape[-1] < 2:
        out[...] = values if size == 1 else values[..., :1]
        return
    head, n = size // 2, values.shape[-1]
    # of the samples from the middle of one mean to that of the next
    share = (np.arange(size) + head - 0.5 * (size - 1)) / size
    for row, target in zip(values.reshape(-1, n), out.reshape(-1, out.shape[-1]), strict=True):
        inner = target[head : head + (n - 1) * size].reshape(n - 1, size)
        before, after = target[:head], target[head + (n - 1) * size :]
        if values.dtype.kind == "f":
            step = np.diff(row)
            np.multiply(step[:, None], share, out=inner)
            inner += row[:-1, None]
            before[:] = row[0] + step[0] * (share[:1] + np.arange(-head, 0) / size)
            after[:] = row[-1] + step[-1] * (share[0] + np.arange(after.size) / size)
        else:
            # both sides have to be valid; a piece begins where its first sample does
            inner[:] = np.minimum(row[:-1], row[1:])[:, None]
            before[:], after[:] = row[0], row[-1]


def _unknown(like: _Values) -> float:
    """Return NaN, False or piece 0, as the type of `like` has it."""
    return np.nan if like.dtype.kind == "f" else 0
