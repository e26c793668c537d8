"""Waterfall: the spectrum of each receiver moment by moment, time from left to right as in the scopes."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtWidgets import QLabel, QVBoxLayout

from radargui.gui.layout import fill, take_out
from radargui.gui.plots.per_receiver import PerReceiver
from radargui.gui.plots.plot import LAST, NOW, Plot
from radargui.gui.scopes.shown import Follower, Shown
from radargui.gui.scopes.spectrum_view import BANDS_HZ, decibels
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray

_SIZE = 256
"""Samples of a spectrum, at four a second for each hertz of half the band: 1/64 of it is told apart."""
_MOST_FRAMES = 400
_EVERY = 6
"""Frames: three pictures take as long as all scopes, and five a second flow well enough."""
_STEP_DB = 5.0
_FADES_DB = 1.0
"""By so much a picture the upper end of the colours follows a signal that got weaker."""


class Waterfall(Plot):
    """Frequency upwards, time to the right, amplitude as colour (viridis: lighter is more, also without colours)."""

    def __init__(self, theme: Theme, number: int, *, with_time: bool) -> None:
        self._picture = pg.ImageItem(axisOrder="row-major")
        self._picture.setColorMap("viridis")
        self._level: FloatArray = np.empty((0, 0))
        self._axes: tuple[FloatArray, FloatArray] = (np.empty(0), np.empty(0))
        self._per_hz = 0.0
        super().__init__(theme, LAST if with_time else "", f"Rx {number} [Hz]", left_px=50, live=True)
        self.getPlotItem().getAxis("left").setTickDensity(0.6)
        self.addItem(self._picture, ignoreBounds=True)
        self.setXRange(-3.0, 0.0, padding=0)
        self.setYRange(-BANDS_HZ[1], BANDS_HZ[1], padding=0)

    def draw(
        self, time_s: FloatArray, frequency_hz: FloatArray, level_db: FloatArray, span: tuple[float, float]
    ) -> None:
        """Draw levels, shape (n_times, n_frequencies), in dB re 1 V; `span`: of the darkest and lightest colour."""
        self._axes, self._level = (time_s, frequency_hz), level_db
        step_s, step_hz = time_s[1] - time_s[0], frequency_hz[1] - frequency_hz[0]
        self._picture.setImage(level_db.T, autoLevels=False, levels=span)
        low, left = frequency_hz[0] - 0.5 * step_hz, time_s[0] - 0.5 * step_s
        self._picture.setRect(QRectF(left, low, step_s * time_s.size, step_hz * frequency_hz.size))

    def set_scale(self, wavelength_m: float, half_band_hz: float) -> None:
        """Show +-half the band."""
        self._per_hz = wavelength_m
        self.setYRange(-half_band_hz, half_band_hz, padding=0)

    def show_nothing(self) -> None:
        """Empty the picture."""
        self._picture.clear()
        self._level = np.empty((0, 0))

    def also(self, value: float, axis: str = "bottom") -> str:
        """Return a frequency as a speed."""
        return f" = {value * self._per_hz:.3f} m/s" if axis == "left" else ""

    def columns(self) -> list[tuple[str, FloatArray]]:
        """Return one column a frequency."""
        time_s, frequency_hz = self._axes
        if not self._level.size:
            return []
        levels = ((f"{one:.6g} Hz [dB re 1 V]", row) for one, row in zip(frequency_hz, self._level.T, strict=True))
        return [(self.words("bottom"), time_s), *levels]


class WaterfallView(PerReceiver):
    """One waterfall a receiver, with one time base."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.plots: list[Waterfall] = []
        self.half_band_hz = BANDS_HZ[1]
        self.words = QLabel()
        self.words.setContentsMargins(6, 0, 6, 2)
        self._column = fill(QVBoxLayout(self), spacing=2)
        self._column.addWidget(self.words)
        self._follower = Follower()
        self._frame = 0
        self._drawn: tuple[object, ...] = ()
        self._top_db = -100.0
        self.show_nothing()

    def make_plots(self, count: int) -> None:
        """Make one waterfall a receiver."""
        take_out(self._column, *self.plots)
        self.plots = [Waterfall(self._theme, number + 1, with_time=number == count - 1) for number in range(count)]
        for number, plot in enumerate(self.plots):
            if number < count - 1:
                plot.setXLink(self.plots[-1])
            self._column.insertWidget(number, plot, 5 if number == count - 1 else 4)

    def show_nothing(self) -> None:
        """Forget what was shown."""
        for plot in self.plots:
            plot.show_nothing()
        self.words.setText("Start shows the spectrum of what comes in, moment by moment")
        self._drawn = ()

    def draw(self, shown: Shown) -> None:
        """Draw what is new; called each frame."""
        band = self._follower.follow(shown, self.half_band_hz)
        self._frame += 1
        state = (band, band.end)
        if state == self._drawn or self._frame % _EVERY or not self.plots:
            return
        count = band.samples_v.shape[1]
        hop = max(_SIZE // 8, count // _MOST_FRAMES)
        amplitude = band.waterfall(_SIZE, hop)
        if amplitude.shape[1] < 2:
            return
        self._drawn = state
        frequency = np.fft.fftshift(np.fft.fftfreq(_SIZE, 1.0 / band.rate_hz))
        frequency = frequency[np.abs(frequency) <= band.half_band_hz]
        newest = shown.time_s(band.end) - 0.5 * _SIZE / band.rate_hz
        time_s = newest - np.arange(amplitude.shape[1])[::-1] * hop / band.rate_hz
        level = decibels(amplitude)
        self._top_db = max(float(np.nanmax(level)), self._top_db - _FADES_DB)
        top = _STEP_DB * np.ceil(self._top_db / _STEP_DB)
        low = min(_STEP_DB * np.floor(float(np.nanmedian(level)) / _STEP_DB), top - _STEP_DB)
        for plot, rows in zip(self.plots, level, strict=False):
            plot.draw(time_s, frequency, rows, (low, top))
            plot.set_scale(shown.setup.radar.wavelength_m, band.half_band_hz)
        self.plots[-1].relabel(NOW if shown.live else LAST)
        self.plots[-1].setXRange(shown.time_s(shown.end) - shown.window_s, shown.time_s(shown.end), padding=0)
        self.words.setText(
            f"Light: {top:.0f} dB re 1 V, dark: {low:.0f} dB; lines {2 * band.rate_hz / _SIZE:.2g} Hz apart"
            " are told apart"
        )
