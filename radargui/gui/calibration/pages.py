"""The pages of the dialog: recordings, what is unknown, and what the calibration found."""

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QFileDialog, QHBoxLayout, QSplitter, QVBoxLayout, QWidget

from radargui.calibration.unknowns import U_UNSTATED, USUAL
from radargui.experiment.calibrating import FALL
from radargui.files.formats import SUFFIXES
from radargui.gui.layout import TIPS, Group, Paragraph, PlainLabel, boxed, button, fill, follow, having, holding
from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import Plot
from radargui.gui.setup_words import UNKNOWNS, called, words_of
from radargui.gui.table import RowModel, RowTable, WordTable
from radargui.gui.theme import Theme, scaled_font
from radargui.model.assumed import uncertain_inputs
from radargui.model.calibrated_setup import KNOWN_TOGETHER, Change, change, changes_since, correlations, setup_key
from radargui.model.calibration import Calibration, Residual
from radargui.model.radar import MAX_RECEIVERS
from radargui.model.rounding import UNKNOWN, plain, with_sign
from radargui.model.setup import Setup
from radargui.model.words import sentence
from radargui.report.content import with_powers
from radargui.system.resources import resources_folder

_RECORDINGS = f"Recordings ({' '.join('*' + suffix for suffix in SUFFIXES)});;All files (*)"
_PATHS = "Known motions (*.toml *.csv);;All files (*)"


@dataclass(frozen=True, slots=True)
class Recorded:
    """A recording, and what is known of its motion: `fall`, or the file that says it."""

    file: Path
    known: str = FALL


class RecordingList(QWidget):
    """Recordings to calibrate from; what is known is set of those that are chosen, of all where none is.

    Parameters
    ----------
    start
        Folder in which recordings are looked for.
    """

    changed = Signal()

    def __init__(self, start: Callable[[], Path]) -> None:
        super().__init__()
        self._start = start
        columns = {
            "Recording": lambda one: one.file.name,
            "What is known of it": lambda one: "free fall" if one.known == FALL else Path(one.known).name,
            "Folder": lambda one: str(one.file.parent),
        }
        model = RowModel[Recorded](columns, lambda one: str(one.file))
        self.table = having(RowTable(model, "calibration.recordings", many=True), accessibleName="Recordings")
        self.add = button("Add recordings…", self._ask_files)
        self.fall = button("Known: free fall", lambda: self.say_known(FALL))
        self.path = button("Known: path…", self._ask_path)
        self.remove = button("Remove", self._remove)
        buttons = fill(QHBoxLayout(), self.add, self.fall, self.path, 1, self.remove, spacing=6)
        words = (
            "Drops of a session are a calibration by themselves, best from several places and heights. With a stage, a "
            f"turntable or a pendulum say how it moves: ready files to copy lie in {resources_folder() / 'paths'}."
        )
        fill(QVBoxLayout(self), Paragraph(words), (self.table, 1), buttons, spacing=6)
        self.show_recordings(())

    def put(self, files: Iterable[Path]) -> None:
        """Add recordings that are not there yet."""
        there = {one.file for one in self.table.rows.entries}
        self.show_recordings([*self.table.rows.entries, *(Recorded(file) for file in files if file not in there)])

    def say_known(self, known: str) -> None:
        """Say what is known of the chosen recordings."""
        chosen = self.table.all_chosen or self.table.rows.entries
        self.show_recordings([replace(one, known=known) if one in chosen else one for one in self.table.rows.entries])

    def show_recordings(self, entries: Iterable[Recorded]) -> None:
        """Show these and no others."""
        self.table.show_rows(entries)
        for one in (self.fall, self.path, self.remove):
            one.setEnabled(bool(self.table.rows.entries))
        self.changed.emit()

    def _remove(self) -> None:
        chosen = self.table.all_chosen
        self.show_recordings([one for one in self.table.rows.entries if one not in chosen])

    def _ask_files(self) -> None:
        names, _ = QFileDialog.getOpenFileNames(self, "Recordings to calibrate from", str(self._start()), _RECORDINGS)
        self.put(map(Path, names))

    def _ask_path(self) -> None:
        name, _ = QFileDialog.getOpenFileName(self, "How it moved", str(resources_folder() / "paths"), _PATHS)
        if name:
            self.say_known(name)


class UnknownsForm(QWidget):
    """What the calibration may change, with what the setup knows of it."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        group = Group("Unknown")
        self.boxes: dict[str, QCheckBox] = {}
        self._priors: dict[str, PlainLabel] = {}
        for name, unknown in UNKNOWNS.items():
            box, prior = QCheckBox(unknown["title"]), PlainLabel()
            having(box, toolTip=TIPS["fields"].get(box.text(), ""), checked=name in USUAL)
            box.toggled.connect(self.changed)
            self.boxes[name], self._priors[name] = box, prior
            group.rows.addRow(box, prior)
        words = (
            "What is not checked stays as the setup has it. Each unknown begins with the setup's value and "
            "uncertainty; where the setup gives none a wide one is taken."
        )
        fill(QVBoxLayout(self), Paragraph(words), group, 1, spacing=6)

    @property
    def free(self) -> tuple[str, ...]:
        """The groups that are checked."""
        return tuple(name for name, box in self.boxes.items() if box.isChecked())

    def show_setup(self, setup: Setup) -> None:
        """Show what a setup knows of each group."""
        plain = setup.model_copy(update={"calibration": type(setup.calibration)()})
        given = [one for one in uncertain_inputs(plain) if not one.assumed]
        for name, unknown in UNKNOWNS.items():
            ends = tuple(unknown["priors"])
            own = [one for one in given if one.key.endswith(ends)]
            said = [f"{called(one.key).partition(':')[0]} ± {words_of(one.key).with_unit(one.u)}" for one in own]
            if ends and not said:
                # of the first receiver: all are written in one unit
                key = f"receiver[1]{ends[0]}" if ends[0].startswith(".") else "tracer.release_position_m"
                said = [f"no uncertainty given: ± {words_of(key).with_unit(U_UNSTATED[name])} taken"]
            self._priors[name].setText(", ".join(said))


_PARAMETERS = ("Parameter", "Before", "After", "Change", "in u")
_RESIDUALS = ("Recording", "Receiver", "Before [mm]", "After [mm]", "Left out [mm]")
_TITLE = 1.5
"""Times the font of the window (chosen by hand): the verdict is what is looked for."""
_MAX_NAMED = 2
"""Pairs of unknowns in one sentence (chosen by hand); the others are counted."""
_KEY = re.compile(r"\b(?:receiver|transmitter|tracer)(?:\.\w+)+")


class ResultView(QWidget):
    """Tables, plot and words of one calibration."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._verdict = ""
        self.title, self.words = PlainLabel(), Paragraph()
        self.title.setFont(scaled_font(self.font(), _TITLE, bold=True))
        self.compared = PlainLabel()
        self.parameters = WordTable(_PARAMETERS, "calibration.parameters")
        self.residuals = WordTable(_RESIDUALS, "calibration.residuals")
        self.plot = Plot(theme, "recording", "rms residual [mm]")
        self.plot.setLogMode(y=True)
        self.plot.getPlotItem().getAxis("bottom").setTickSpacing(major=5, minor=1)
        # of whole decades: the words of what lies between them would lie upon another
        self.plot.getPlotItem().getAxis("left").setTickSpacing(major=1, minor=1)
        self.plot.getPlotItem().getAxis("left").setStyle(maxTextLevel=0)
        self._after, self._before = (
            [self.plot.marker(f"receivers.{n}", symbol, size, f"Rx {n + 1} {when}") for n in range(MAX_RECEIVERS)]
            for when, symbol, size in (("after", "o", 8), ("before", "x", 9))
        )
        self.key = Key(theme)
        left = boxed(QVBoxLayout(), self.compared, (self.parameters, 1), spacing=4)
        right = boxed(QVBoxLayout(), (self.residuals, 3), (self.plot, 4), self.key, spacing=4)
        parts = holding(QSplitter(Qt.Orientation.Horizontal, childrenCollapsible=False), left, right)
        having(parts, objectName="calibration.parts", sizes=[490, 550])
        fill(QVBoxLayout(self), self.title, self.words, (parts, 1), spacing=6)
        follow(theme.changed, self._colour)

    def show_calibration(self, found: Calibration) -> None:
        """Show a calibration against the setup that was there."""
        self._verdict = found.verdict
        self.title.setText(found.verdict.capitalize())
        self.words.setText("\n".join(found_words(found)))
        u = np.sqrt(np.diag(found.covariance))
        columns = zip(found.names, found.before, found.u_before, found.values, u, strict=True)
        changes = [change(name, (old, u_old), (new, u_new)) for name, old, u_old, new, u_new in columns]
        self._show_changes("Before: the setup as it is", changes)
        rows = []
        for one in found.residuals:
            rms = map(_mm, (one.rms_before_m, one.rms_m, one.left_out_rms_m))
            rows.append((one.file, str(one.receiver or "all"), *rms))
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
            in_u = with_sign(one.in_u, 1) if math.isfinite(one.in_u) else UNKNOWN
            rows.append((f"{called(setup_key(one.name))}, {one.unit}", one.old, one.new, one.difference, in_u))
        self.parameters.show_rows(rows)

    def _draw(self, residuals: Sequence[Residual]) -> None:
        count = max((one.receiver for one in residuals), default=0)
        receivers = [("●", f"receivers.{number}", f"Rx {number + 1}") for number in range(count)]
        self.key.show_entries(*receivers, ("●", "text", "after"), ("×", "text", "before"))
        files = list(dict.fromkeys(one.file for one in residuals))
        known = [1e3 * x for one in residuals for x in (one.rms_m, one.rms_before_m) if x > 0.0]
        if known:
            low, high = math.floor(math.log10(min(known))), math.ceil(math.log10(max(known)))
            self.plot.setYRange(low, max(high, low + 2), padding=0.0)
        for receiver in range(1, MAX_RECEIVERS + 1):
            own = [one for one in residuals if one.receiver == receiver]
            at = [files.index(one.file) + 1 for one in own]
            self._after[receiver - 1].setData(at, [1e3 * one.rms_m for one in own])
            self._before[receiver - 1].setData(at, [1e3 * one.rms_before_m for one in own])

    def _colour(self) -> None:
        colours = self._theme.colours
        colour = {"good": colours.good, "usable": colours.busy, "refused": colours.alarm}.get(self._verdict)
        self.title.setStyleSheet(f"color: {colour or colours.text};")


def found_words(found: Calibration) -> list[str]:
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
    if pairs := correlations(found.covariance, found.names, KNOWN_TOGETHER):
        named = (f"{a} with {b} ({r:+.2f})" for a, b, r in pairs[:_MAX_NAMED])
        more = len(pairs) - _MAX_NAMED
        lines.append(f"known only together: {'; '.join(named)}{f'; {more} more pairs' if more > 0 else ''}")
    lines = [_KEY.sub(lambda key: called(setup_key(key[0])), line) for line in (*lines, *found.notes)]
    return [sentence(with_powers(line)) for line in lines]


def _together(values: list[float]) -> float:
    return math.sqrt(sum(value**2 for value in values) / len(values))


def _mm(value: float) -> str:
    return plain(value, 2, scale=1e3)
