"""The signals of a run's motion as the live panels show those that come in: spectrum, waterfall, IQ planes."""

from __future__ import annotations

import math

import numpy as np
from PySide6.QtWidgets import QVBoxLayout, QWidget

from radargui.acquisition.ring import Ring
from radargui.gui.control.state import Feed
from radargui.gui.layout import fill, ticking
from radargui.gui.scopes.iq_plane_panel import IQPlanePanel
from radargui.gui.scopes.shown import Shown
from radargui.gui.scopes.spectrum_view import BANDS_HZ, SpectrumView, WaterfallView
from radargui.model.recording import Block
from radargui.model.result import RunResult
from radargui.report.curves import RunCurves, every

_MOST_S = 8.0
"""Of a motion, its beginning: the first bounces of a drop; the spectra of more would take their time."""
_FRAME_MS = 20
_POINTS = 3000
"""Samples in a plane: more look the same."""


def motion_of(result: RunResult) -> Shown | None:
    """Return the samples of the motion as the scopes show samples; None without any."""
    recording, segment = result.recording, result.segment
    if recording.n_samples < 2:
        return None
    rate_hz = recording.digitisation.sample_rate_hz
    first, last = (segment.first, segment.last) if segment is not None else (0, recording.n_samples)
    last = min(last, first + round(_MOST_S * rate_hz))
    volts = recording.digitisation.volts(recording.raw[:, first:last])
    ring = Ring(len(volts), last - first, np.float64)
    ring.append(Block(volts, 0))
    feed = Feed(ring, recording.digitisation, None, result.setup)
    zero = round((result.zero[0] - float(recording.time_s()[first])) * rate_hz)
    return Shown(feed, last - first, zero, (last - first) / rate_hz, live=False)


class SignalView(QWidget):
    """Shows the motion in a live view, which takes it in piece by piece."""

    def __init__(self, view: SpectrumView | WaterfallView) -> None:
        super().__init__()
        self.view, self._left = view, 0
        self._shown: Shown | None = None
        self._next = ticking(self, _FRAME_MS, self._draw)
        fill(QVBoxLayout(self), (view, 1))

    def clear(self) -> None:
        """Forget the run."""
        self._shown = None
        self._next.stop()
        self.view.show_nothing()

    def show_curves(self, result: RunResult, shown: Shown) -> None:
        """Show a motion, the whole of the band that it fills."""
        self.clear()
        self._shown = shown
        if isinstance(self.view, WaterfallView):
            self.view.set_receivers(shown.feed.n_receivers)
            self.view.plots[-1].relabel(f"time after {result.zero[1]} [s]")
        # a sphere of 10 m/s gives less than this everywhere
        nyquist_hz = 0.5 * shown.feed.rate_hz
        self.view.half_band_hz = max(band for band in BANDS_HZ[:3] if band <= nyquist_hz or band == BANDS_HZ[0])
        # as often as the past takes, and until the view draws it
        self._left = 16 + math.ceil(4.0 * shown.window_s)
        self._next.start()

    def _draw(self) -> None:
        self._left -= 1
        if self._shown is None or self._left < 0:
            self._next.stop()
        elif self.isVisible():
            self.view.draw(self._shown)


class PlanesView(IQPlanePanel):
    """Q against I of the motion, as recorded above and corrected below."""

    def show_curves(self, _result: RunResult, curves: RunCurves) -> None:
        """Draw a result."""
        self.set_receivers(len(curves.receivers))
        for number, one in enumerate(curves.receivers):
            for planes, pair in ((self.raw, one.raw), (self.corrected, one.corrected)):
                kept = every(pair.plane.x.size, _POINTS)
                planes[number].draw(pair.plane.x[kept], pair.plane.y[kept])
