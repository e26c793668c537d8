"""Guide the operator through the wiring check, and collect what the channels show."""

from dataclasses import dataclass

import numpy as np

from radargui.acquisition.ring import Ring
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.recording import Block, Digitisation
from radargui.model.setup import Setup
from radargui.model.wiring import WiringStep, wiring_steps
from radargui.processing.wiring import WiringReport, WiringSamples, check_wiring

_RATE_HZ = 2000.0
"""Samples are averaged down to about this rate: a hand and a tracer in a hand are slow."""
_AT_END = 0.999
"""Share of the range from which a sample counts as clipped."""


@dataclass(frozen=True, slots=True)
class GuideState:
    """Where the check is.

    Attributes
    ----------
    step
        The present step; None when all are done.
    number, total
        Which step, counted from 1, of how many.
    measuring
        Whether the step is measured now; before that the operator gets ready.
    left_s
        Seconds until the measurement begins, or ends.
    """

    step: WiringStep | None
    number: int
    total: int
    measuring: bool
    left_s: float


class WiringGuide:
    """Takes samples as they come, by `push` from a source or by `poll` from a ring; one thread.

    Parameters
    ----------
    setup
        What is thought to be wired.
    digitisation
        How samples are digitised.
    first_index
        Absolute index at which the check begins.
    """

    def __init__(self, setup: Setup, digitisation: Digitisation, *, first_index: int = 0) -> None:
        self._setup = setup
        self._digitisation = digitisation
        self._origin = self._next = first_index
        self._factor = max(1, int(digitisation.sample_rate_hz / _RATE_HZ))
        self._steps = wiring_steps(setup.n_receivers)
        self._parts: list[list[FloatArray]] = [[] for _ in self._steps]
        self._clipped = np.zeros(digitisation.n_channels)
        self._count = 0

    @property
    def is_done(self) -> bool:
        """Whether all steps were measured."""
        return self._time_s() >= self._steps[-1].end_s

    def state(self) -> GuideState:
        """Return where the check is, by the samples that came."""
        now_s = self._time_s()
        total = len(self._steps)
        for number, step in enumerate(self._steps, start=1):
            if now_s < step.end_s:
                measuring = now_s >= step.start_s
                return GuideState(step, number, total, measuring, (step.end_s if measuring else step.start_s) - now_s)
        return GuideState(None, total, total, measuring=False, left_s=0.0)

    def push(self, block: Block) -> None:
        """Take the next block of a source."""
        self._take(block.first_index, self._digitisation.volts(block.samples))

    def poll(self, ring: Ring) -> GuideState:
        """Take what came into the ring since the last time, and return where the check is.

        What has left the ring meanwhile is missing from the measurement.
        """
        span = ring.since(self._next)
        if span.volts.shape[1]:
            self._take(span.first_index, span.volts)
        return self.state()

    def report(self) -> WiringReport:
        """Return what was found, from what was measured so far."""
        quiet, away, *waves = (self._joined(parts) for parts in self._parts)
        clipped = self._clipped / max(self._count, 1)
        rate_hz = self._digitisation.sample_rate_hz / self._factor
        return check_wiring(WiringSamples(rate_hz, quiet, away, tuple(waves), clipped), self._setup)

    def _time_s(self) -> float:
        return (self._next - self._origin) / self._digitisation.sample_rate_hz

    def _take(self, first_index: int, volts: FloatArray) -> None:
        rate_hz = self._digitisation.sample_rate_hz
        self._next = first_index + volts.shape[1]
        before = first_index - self._origin
        for step, parts in zip(self._steps, self._parts, strict=True):
            begin, end = (max(round(edge_s * rate_hz) - before, 0) for edge_s in (step.start_s, step.end_s))
            measured = volts[:, begin:end]
            if measured.shape[1]:
                self._clipped += self._at_end(measured).sum(axis=1)
                self._count += measured.shape[1]
                parts.append(self._averaged(measured))

    def _at_end(self, volts: FloatArray) -> BoolArray:
        limits = self._digitisation.full_scale_v()
        if limits is None:
            return np.asarray(np.abs(volts) >= _AT_END * self._setup.daq.range_v)
        middle, half = limits.mean(axis=1, keepdims=True), np.ptp(limits, axis=1)[:, None] / 2.0
        return np.asarray(np.abs(volts - middle) >= _AT_END * np.abs(half))

    def _averaged(self, volts: FloatArray) -> FloatArray:
        """Return means of `factor` samples; the rest of a block that fills no mean is left out."""
        n_means = volts.shape[1] // self._factor
        whole = volts[:, : n_means * self._factor]
        return np.asarray(whole.reshape(volts.shape[0], n_means, self._factor).mean(axis=2))

    def _joined(self, parts: list[FloatArray]) -> FloatArray:
        return np.concatenate([np.empty((self._digitisation.n_channels, 0)), *parts], axis=1)
