"""Values of a gapless stretch laid back into the whole recording: NaN and invalid outside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radargui.correction.published import ChannelSteps, PublishedSteps
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.corrected import CorrectedIQ
from radargui.model.path import PathLengths
from radargui.model.recording import Recording
from radargui.model.segment import Segment
from radargui.model.track import Track


class Whole:
    """Lays values of the samples `stretch` of a recording back into all its samples.

    Parameters
    ----------
    recording
        Gives the number and the times of the samples.
    stretch
        Samples that the values belong to.
    """

    def __init__(self, recording: Recording, stretch: slice) -> None:
        self._time_s = recording.time_s()
        self._stretch = stretch
        self._start = int(stretch.start)

    def segment(self, segment: Segment) -> Segment:
        """Return the segment counted in samples of the recording."""
        return segment.counted_from(-self._start)

    def corrected(self, corrected: CorrectedIQ) -> CorrectedIQ:
        """Return corrected IQ of all samples."""
        return replace(
            corrected,
            time_s=self._time_s,
            i=self._spread(corrected.i),
            q=self._spread(corrected.q),
            u_phase_rad=self._spread(corrected.u_phase_rad),
            valid=self._spread_mask(corrected.valid),
            steps=tuple(self._steps(step) for step in corrected.steps),
        )

    def paths(self, paths: PathLengths) -> PathLengths:
        """Return path lengths of all samples."""
        return PathLengths(
            self._time_s,
            self._spread(paths.phase_rad),
            self._spread(paths.change_m),
            self._spread(paths.u_m),
            self._spread_mask(paths.valid),
        )

    def track(self, track: Track) -> Track:
        """Return the track of all samples."""
        return replace(
            track,
            time_s=self._time_s,
            position_m=self._spread(track.position_m),
            u_position_m=self._spread(track.u_position_m),
            valid=self._spread_mask(track.valid),
        )

    def _steps(self, step: object) -> object:
        return (
            PublishedSteps(self._channel(step.i), self._channel(step.q)) if isinstance(step, PublishedSteps) else step
        )

    def _channel(self, steps: ChannelSteps) -> ChannelSteps:
        return replace(
            steps,
            segment=self.segment(steps.segment),
            peaks=steps.peaks + self._start,
            valleys=steps.valleys + self._start,
            zero_crossings=steps.zero_crossings + self._start,
            bias=self._spread(steps.bias),
            scale=self._spread(steps.scale),
        )

    def _spread(self, values: FloatArray) -> FloatArray:
        out = np.full((*values.shape[:-1], self._time_s.size), np.nan)
        out[..., self._stretch] = values
        return out

    def _spread_mask(self, values: BoolArray) -> BoolArray:
        out = np.zeros((*values.shape[:-1], self._time_s.size), dtype=np.bool_)
        out[..., self._stretch] = values
        return out
