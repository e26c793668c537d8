"""Spectra of I + jQ: Doppler lines by frequency and by speed of the path, hum by name; spectra over time."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QMargins, QRectF
from PySide6.QtWidgets import QLabel, QSizePolicy, QVBoxLayout

from radargui.acquisition.baseband import Baseband, SpectralLine, Spectrum
from radargui.gui.layout import fill, having, take_out
from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import LAST, PerReceiver, Plot
from radargui.gui.scopes.shown import Follower, Shown
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.radar import MAX_RECEIVERS
from radargui.model.rounding import plain, with_sign

BANDS_HZ = (100.0, 300.0, 1000.0, 3000.0, 10000.0, 100_000.0)
"""Half bands that may be chosen: from hum and slow swings to the converter's own noise."""
_MIN_V = 1e-6
"""Below any converter's noise: what is nothing at all, such as a simulation without noise, is drawn here."""
_MAX_POINTS = 4000
"""Of a curve: more than the pixels of any screen; where there are more, the highest of neighbours."""


def decibels(amplitude_v: FloatArray | float) -> FloatArray:
    """Return 20 log10(amplitude / 1 V)."""
    return np.asarray(20.0 * np.log10(np.maximum(amplitude_v, _MIN_V)))


class _FrequencyPlot(Plot):
    """One axis, `of_hz`, has Doppler frequencies, which are speeds of the path."""

    of_hz = "bottom"
    _per_hz = 0.0

    def set_scale(self, wavelength_m: float, half_band_hz: float) -> None:
        """Show +-half the band; a speed is wavelength times frequency."""
        self._per_hz = wavelength_m
        name = "xRange" if self.of_hz == "bottom" else "yRange"
        self.setRange(**{name: (-half_band_hz, half_band_hz)}, padding=0)

    def also(self, value: float, axis: str = "bottom") -> str:
        """Return a frequency as a speed."""
        return f" = {value * self._per_hz:.3f} m/s" if axis == self.of_hz else ""


class SpectrumPlot(_FrequencyPlot):
    """All receivers in one plot; the upper axis has the speed of the path."""

    def __init__(self, theme: Theme) -> None:
        super().__init__(
            theme, "Doppler frequency [Hz], positive: the path gets longer", "amplitude [dB re 1 V]", live=True
        )
        self.getPlotItem().showAxis("top")
        axis = self.getPlotItem().getAxis("top")
        axis.setLabel("speed of the path, dL/dt [m/s]")
        # no figures before the wavelength is known
        axis.setStyle(tickLength=-4, showValues=False)
        self.setXRange(-BANDS_HZ[1], BANDS_HZ[1], padding=0)
        self.curves_ = [self.fast_line(f"receivers.{n}", f"Rx {n + 1}") for n in range(MAX_RECEIVERS)]
        self._mains = self.marker("text", "t", 9, "mains")
        self.setYRange(-100.0, 0.0, padding=0)

    def set_scale(self, wavelength_m: float, half_band_hz: float) -> None:
        """Show +-half the band, and its speeds on the upper axis."""
        super().set_scale(wavelength_m, half_band_hz)
        self.getPlotItem().getAxis("top").setScale(wavelength_m)
        self.getPlotItem().getAxis("top").setStyle(showValues=True)

    def draw(self, spectrum: Spectrum, mains: list[SpectralLine]) -> None:
        """Draw spectra, and a mark at each line of the mains."""
        size = -(-spectrum.frequency_hz.size // _MAX_POINTS)
        edges = np.arange(0, spectrum.frequency_hz.size, size)
        level = decibels(np.maximum.reduceat(spectrum.amplitude_v, edges, axis=1))
        for curve, values in zip(self.curves_, level, strict=False):
            curve.setData(spectrum.frequency_hz[edges], values)
        at = np.array([line.frequency_hz for line in mains])
        self._mains.setData(at, decibels(np.array([line.amplitude_v for line in mains])) + 3.0)
        floor = float(np.median(level))
        self.fit_y(floor - 15.0, float(level.max()) + 5.0)


class _OfFrequencies(PerReceiver):
    """What shows frequencies: the band that it follows, how often it draws, and words below the plots."""

    plots: Sequence[Plot]

    def __init__(self, theme: Theme, every: int) -> None:
        super().__init__()
        self._theme, self._every = theme, every
        # in a narrow dock their end is told by the tip: the plots would be scrolled for them
        self.words = having(QLabel(), contentsMargins=QMargins(6, 0, 6, 2))
        self.words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._column = fill(QVBoxLayout(self), self.words)
        self.half_band_hz = BANDS_HZ[1]
        self._follower = Follower()
        self._frame = 0
        self._drawn: tuple[object, ...] = ()

    def show_nothing(self) -> None:
        """Forget what was shown."""
        for plot in self.plots:
            plot.show_nothing()
        self._drawn = ()

    def draw(self, shown: Shown) -> None:
        """Draw what came since the last picture, in the frames that draw; called each frame."""
        band = self._follower.follow(shown, self.half_band_hz)
        self._frame += 1
        if self.plots and self._frame % self._every == 0 and (band, band.end) != self._drawn:
            self.draw_band(shown, band)

    def draw_band(self, shown: Shown, band: Baseband) -> None:
        """Draw the signals of what is shown."""
        raise NotImplementedError


class SpectrumView(_OfFrequencies):
    """Spectra of the window that ends with what is shown; beneath them the lines in words."""

    def __init__(self, theme: Theme) -> None:
        # eight spectra a second are read well, and cost little
        super().__init__(theme, every=4)
        self.plots: list[SpectrumPlot] = []
        self.key = Key(theme)
        self._column.insertWidget(0, self.key)
        self.set_receivers(1)  # one plot for all
        self.spectrum: Spectrum | None = None
        self.show_nothing()

    def make_plots(self, count: int) -> None:
        """Make the plot."""
        self.plots = [SpectrumPlot(self._theme) for _ in range(count)]
        self._column.insertWidget(1, self.plots[0], 1)

    def show_nothing(self) -> None:
        """Forget what was shown."""
        super().show_nothing()
        self.spectrum = None
        self.words.setText("Start shows the spectrum of what comes in")

    def draw_band(self, shown: Shown, band: Baseband) -> None:
        """Draw the spectra, and say which lines they have."""
        spectrum = band.spectrum()
        if spectrum is None:
            self.words.setText("Too few samples since the last ones that were lost")
            return
        if not self._drawn or self._drawn[0] is not band:
            self.plots[0].set_scale(shown.feed.setup.radar.wavelength_m, band.half_band_hz)
        self._drawn, self.spectrum = (band, band.end), spectrum
        receivers = range(len(spectrum.amplitude_v))
        self.key.show_entries(*(("▬", f"receivers.{n}", f"Rx {n + 1}") for n in receivers))
        mains = [spectrum.mains(receiver) for receiver in receivers]
        self.plots[0].draw(spectrum, list(chain(*mains)))
        lines = [self._line(shown, spectrum, receiver, own) for receiver, own in enumerate(mains)]
        said = (
            f"{spectrum.span_s:.2g} s of samples, so lines {plain(spectrum.resolution_hz, 2)} Hz apart are told apart"
        )
        words = "\n".join((*lines, said))
        having(self.words, text=words, toolTip=words)

    @staticmethod
    def _line(shown: Shown, spectrum: Spectrum, receiver: int, mains: list[SpectralLine]) -> str:
        line = spectrum.strongest(receiver)
        said = "no line above the noise"
        if line is not None:
            # dL/dt: how fast the path Tx - sphere - Rx gets longer
            speed = shown.feed.setup.radar.wavelength_m * line.frequency_hz
            said = f"strongest {with_sign(line.frequency_hz, 1)} Hz = {with_sign(speed, 3)} m/s, {_level(line)}"
        hum = ", ".join(f"{one.frequency_hz:.1f} Hz {_level(one)}" for one in mains)
        return f"Rx {receiver + 1}: {said}" + (f"; mains ▼ {hum}" if hum else "")


def _level(line: SpectralLine) -> str:
    return f"{decibels(line.amplitude_v):.1f} dB"


_SIZE = 256
"""Samples of a spectrum, at four a second for each hertz of half the band: 1/64 of it is told apart."""
_MAX_FRAMES = 400
"""Spectra side by side, about (chosen by hand): fewer make steps in time, each more costs a transform."""
_STEP_DB = 5.0
"""The ends of the colours are whole numbers of it: a colour does not change its meaning with each picture."""
_FADES_DB = 1.0
"""By so much a picture the upper end of the colours follows a signal that got weaker."""


class Waterfall(_FrequencyPlot):
    """Frequency upwards, time to the right, amplitude as colour (viridis: lighter is more, also without colours)."""

    of_hz = "left"

    def __init__(self, theme: Theme, number: int, *, with_time: bool) -> None:
        self._picture = pg.ImageItem(axisOrder="row-major")
        self._picture.setColorMap("viridis")
        self._level: FloatArray = np.empty((0, 0))
        self._axes: tuple[FloatArray, FloatArray] = (np.empty(0), np.empty(0))
        axes = (LAST if with_time else "", f"Rx {number} [Hz]")
        super().__init__(theme, *axes, left_px=70, live=True, density=0.6, figures_below=with_time)
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

    def show_nothing(self) -> None:
        """Empty the picture."""
        self._picture.clear()
        self._level = np.empty((0, 0))

    def columns(self) -> list[tuple[str, FloatArray]]:
        """Return one column a frequency."""
        time_s, frequency_hz = self._axes
        if not self._level.size:
            return []
        levels = ((f"{one:.6g} Hz [dB re 1 V]", row) for one, row in zip(frequency_hz, self._level.T, strict=True))
        return [(self.words("bottom"), time_s), *levels]


class WaterfallView(_OfFrequencies):
    """One waterfall a receiver, with one time base."""

    def __init__(self, theme: Theme) -> None:
        # three pictures take as long as all scopes, and five a second flow well enough
        super().__init__(theme, every=6)
        self.plots: list[Waterfall] = []
        self._top_db = -100.0
        self.show_nothing()

    def make_plots(self, count: int) -> None:
        """Make one waterfall a receiver."""
        take_out(self._column, *self.plots)
        last = count - 1
        self.plots = [Waterfall(self._theme, number + 1, with_time=number == last) for number in range(count)]
        for number, plot in enumerate(self.plots):
            plot.setXLink(None if number == last else self.plots[last])
            self._column.insertWidget(number, plot, 5 if number == last else 4)

    def show_nothing(self) -> None:
        """Forget what was shown."""
        super().show_nothing()
        self.words.setText("Start shows the spectrum of what comes in, moment by moment")

    def draw_band(self, shown: Shown, band: Baseband) -> None:
        """Draw the spectra of all moments."""
        count = band.samples_v.shape[1]
        hop = max(_SIZE // 8, count // _MAX_FRAMES)
        amplitude = band.waterfall(_SIZE, hop)
        if amplitude.shape[1] < 2:
            return
        self._drawn = (band, band.end)
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
            plot.set_scale(shown.feed.setup.radar.wavelength_m, band.half_band_hz)
        self.plots[-1].setXRange(shown.time_s(shown.end) - shown.window_s, shown.time_s(shown.end), padding=0)
        apart = f"tells lines {plain(2 * band.rate_hz / _SIZE, 2)} Hz apart"
        words = f"Light: {top:z.0f} dB re 1 V, dark: {low:z.0f} dB; {apart}"
        having(self.words, text=words, toolTip=words)
