"""What a calibration found: verdict, values before and after, residuals, and what the data cannot tell."""

import math
import re
from collections.abc import Iterable, Sequence

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QSplitter, QVBoxLayout, QWidget

from radargui.gui.layout import Paragraph, PlainLabel, fill, follow
from radargui.gui.plots.plot import Plot
from radargui.gui.setup.words import called
from radargui.gui.table import WordTable
from radargui.gui.theme import Theme, scaled_font
from radargui.model.calibrated_setup import Change, change, changes_since, correlations, setup_key
from radargui.model.calibration import Calibration, Residual
from radargui.model.rounding import UNKNOWN, plain

_PARAMETERS = ("Parameter", "Before", "After", "Change", "in u")
_RESIDUALS = ("Recording", "Receiver", "Before [mm]", "After [mm]", "Left out [mm]")
_TITLE = 1.5
_RECEIVERS, _MOST_NAMED, _TOGETHER = 4, 2, 0.9

_KEY = re.compile(r"\b(?:receiver|transmitter|tracer)(?:\.\w+)+")


class ResultView(QWidget):
    """Tables, plot and words of one calibration."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._verdict, self._receivers = "", 0
        self.title, self.words = PlainLabel(), Paragraph()
        self.title.setFont(scaled_font(self.font(), _TITLE, bold=True))
        self.compared = PlainLabel()
        self.parameters = WordTable(_PARAMETERS, "calibration.parameters")
        self.residuals = WordTable(_RESIDUALS, "calibration.residuals")
        self.plot = Plot(theme, "recording", "rms residual [mm]")
        self.plot.setLogMode(y=True)
        self.plot.getPlotItem().getAxis("bottom").setTickSpacing(major=5, minor=1)
        self._after = [self.plot.marker(f"receivers.{n}", size=8, name=f"Rx {n + 1} after") for n in range(_RECEIVERS)]
        self._before = [
            self.plot.marker(f"receivers.{n}", "x", size=9, name=f"Rx {n + 1} before") for n in range(_RECEIVERS)
        ]
        self.key = QLabel()
        left, right = QWidget(), QWidget()
        fill(QVBoxLayout(left), self.compared, (self.parameters, 1), spacing=4)
        fill(QVBoxLayout(right), (self.residuals, 3), (self.plot, 4), self.key, spacing=4)
        parts = QSplitter(Qt.Orientation.Horizontal)
        parts.setObjectName("calibration.parts")
        for part in (left, right):
            parts.addWidget(part)
        parts.setSizes([540, 440])
        parts.setChildrenCollapsible(False)
        fill(QVBoxLayout(self), self.title, self.words, (parts, 1), spacing=6)
        follow(theme.changed, self._colour)

    def show_calibration(self, found: Calibration) -> None:
        """Show a calibration against the setup that was there."""
        self._verdict = found.verdict
        self.title.setText(found.verdict.capitalize())
        self.words.setText("\n".join(words_of(found)))
        u = np.sqrt(np.diag(found.covariance))
        columns = zip(found.names, found.before, found.u_before, found.values, u, strict=True)
        changes = [change(name, (old, u_old), (new, u_new)) for name, old, u_old, new, u_new in columns]
        self._show_changes("Before: the setup as it is", changes)
        rows = [
            (one.file, str(one.receiver) if one.receiver else "all", *map(_mm, _rms(one))) for one in found.residuals
        ]
        self.residuals.show_rows(rows)
        self._draw(found.residuals)
        self._colour()

    def show_older(self, name: str, old: Calibration, new: Calibration) -> None:
        """Show an older calibration in the place of the setup before."""
        self._show_changes(f"Before: {name}, of {old.origin.made_at[:10]}", changes_since(old, new))

    def _show_changes(self, against: str, changes: Iterable[Change]) -> None:
        self.compared.setText(against)
        rows = []
        for one in changes:
            in_u = f"{one.in_u:+.1f}" if math.isfinite(one.in_u) else UNKNOWN
            rows.append((f"{called(setup_key(one.name))}, {one.unit}", one.old, one.new, one.difference, in_u))
        self.parameters.show_rows(rows)

    def _draw(self, residuals: Sequence[Residual]) -> None:
        self._receivers = max((one.receiver for one in residuals), default=0)
        files = list(dict.fromkeys(one.file for one in residuals))
        known = [1e3 * x for one in residuals for x in (one.rms_m, one.rms_before_m) if x > 0.0]
        if known:
            # whole decades: between them the words of the axis would lie upon another
            low, high = math.floor(math.log10(min(known))), math.ceil(math.log10(max(known)))
            self.plot.setYRange(low, max(high, low + 2), padding=0.0)
        for receiver in range(1, _RECEIVERS + 1):
            own = [one for one in residuals if one.receiver == receiver]
            at = [files.index(one.file) + 1 for one in own]
            self._after[receiver - 1].setData(at, [1e3 * one.rms_m for one in own])
            self._before[receiver - 1].setData(at, [1e3 * one.rms_before_m for one in own])

    def _colour(self) -> None:
        colours = self._theme.colours
        colour = {"good": colours.good, "usable": colours.busy, "refused": colours.alarm}.get(self._verdict)
        self.title.setStyleSheet(f"color: {colour or colours.text};")
        shown = enumerate(colours.receivers[: self._receivers], 1)
        receivers = " ".join(f'<span style="color:{own}">● Rx {n}</span>' for n, own in shown)
        self.key.setText(f"{receivers} after, × before")


def words_of(found: Calibration) -> list[str]:
    """Return the reason, cross-validation, what cannot be told, and what is known only together, a line each."""
    lines = [found.reason]
    whole = [one for one in found.residuals if one.receiver == 0] or list(found.residuals)
    left_out = [one for one in whole if math.isfinite(one.left_out_rms_m)]
    if left_out:
        before = _mm(_together([one.rms_before_m for one in left_out]))
        after = _mm(_together([one.left_out_rms_m for one in left_out]))
        lines.append(f"cross-validation: recordings that were left out agree within {after} mm (before: {before} mm)")
    if untold := [words for words in found.undetermined if words not in found.reason]:
        lines.append(f"the data cannot tell: {'; '.join(untold)}")
    if pairs := correlations(found.covariance, found.names, _TOGETHER):
        named = (f"{a} with {b} ({r:+.2f})" for a, b, r in pairs[:_MOST_NAMED])
        more = len(pairs) - _MOST_NAMED
        lines.append(f"known only together: {'; '.join(named)}{f'; {more} more pairs' if more > 0 else ''}")
    lines = [_KEY.sub(lambda key: called(setup_key(key[0])), line) for line in (*lines, *found.notes)]
    return [f"{line[:1].upper()}{line[1:].rstrip('.')}." for line in lines]


def _together(values: list[float]) -> float:
    return math.sqrt(sum(value**2 for value in values) / len(values))


def _rms(one: Residual) -> tuple[float, float, float]:
    return one.rms_before_m, one.rms_m, one.left_out_rms_m


def _mm(value: float) -> str:
    return plain(value, 2, scale=1e3)
