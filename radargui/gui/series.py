"""The panel of the series: what its drops gave, e against speed and more, its distribution, falls, in words."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QHBoxLayout, QPlainTextEdit, QVBoxLayout, QWidget

from radargui.gui.background import OneAtATime
from radargui.gui.layout import Choice, OneLine, Pages, PlainLabel, button, fill, having, labelled
from radargui.gui.panels import Actions
from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import Plot
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.services import Services
from radargui.gui.table import RowModel, RowTable
from radargui.gui.theme import Theme
from radargui.model.rounding import COVERAGE, UNKNOWN, alone, plain, to_digits_of_u
from radargui.model.words import counted, sentence
from radargui.report.content import with_powers
from radargui.report.facts import (
    ReportFacts,
    e_label,
    e_span,
    histogram_of,
    mean_gravity,
    points_of,
    report_facts,
    session_look,
    shown_fits,
    speed_points,
)
from radargui.restitution.dependence import COVARIATES
from radargui.restitution.findings import UNNAMED, Findings, SessionFindings
from radargui.restitution.speed_models import SpeedFit, model_names, title_of
from radargui.restitution.statistics import Statistics
from radargui.session.session import Session

_LEFT = 62
"""Width of the left axes in pixels (chosen by hand): in less the figures are cut, more is taken from the curves."""
_LONGEST_NAME, _DATE = 24, len("2026-01-31T")
"""Letters of a session in the key: at most (chosen by hand; a name by date and time has 19), and those of its date."""
_BEST = "best"
_SIGNS = (("●", "o"), ("■", "s"), ("▲", "t1"), ("◆", "d"), ("▼", "t"))
"""In the order of `canvas.MARKS`."""
_DIGITS = 2
"""Of an uncertainty (GUM, 7.2.6)."""
_PAGES = ("table", "speeds", "spread", "falls", "words")
_SPEED = "speed"


@dataclass(frozen=True, slots=True)
class SeriesRow:
    """The statistics of one quantity of one session; `scale` from its unit to the one shown."""

    session: str
    quantity: str
    found: Statistics
    scale: float = 1.0


def _scattered(row: SeriesRow, value: float | None) -> str:
    return with_powers(to_digits_of_u(value, row.found.u, row.scale))


# title of a column, and what stands in it
COLUMNS: dict[str, Callable[[SeriesRow], str]] = {
    "Session": lambda row: row.session,
    "Quantity": lambda row: row.quantity,
    "n": lambda row: str(row.found.n),
    "Mean": lambda row: alone(row.found.mean, row.found.u, row.scale),
    "Standard\ndeviation": lambda row: _scattered(row, row.found.standard_deviation),
    "Standard\nerror": lambda row: _scattered(row, row.found.standard_error),
    "Combined\nu": lambda row: with_powers(plain(row.found.combined, _DIGITS, scale=row.scale)),
}
TIP = (
    "Over the drops that count: standard deviation of one drop, standard error of the mean, and its combined standard "
    "uncertainty with what all drops share (antennas, sphere)"
)


def rows_of(found: SessionFindings) -> tuple[SeriesRow, ...]:
    """Return the lines of a session, as `restitution` computed them."""
    series, name = found.series, found.name
    return (
        SeriesRow(name, "e", series.e),
        SeriesRow(name, "g [m/s²]", series.g_m_s2),
        SeriesRow(name, "Fall [mm]", series.drop_height_m, 1e3),
        SeriesRow(name, "Impact [m/s]", series.impact_speed_m_s),
    )


class SpeedView(QWidget):
    """e of all valid impacts against their speed, with the model that the operator chose, or the best one.

    Or against what e may depend on besides, brought to one speed.
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._facts: ReportFacts | None = None
        models = ((name, title_of(name)) for name in model_names())
        self.model = having(Choice(((_BEST, "best described (AICc)"), *models)), accessibleName="Model")
        self.model.setToolTip("Model of e against the impact speed: what is drawn over the points, as in the report")
        self.model.currentIndexChanged.connect(self._draw)
        others = ((name, one.name) for name, one in COVARIATES.items())
        self.against = having(Choice(((_SPEED, "impact speed"), *others)), accessibleName="Against")
        self.against.setToolTip(
            "What e is drawn against; all but the speed with e brought to one speed by the best model"
        )
        self.against.currentIndexChanged.connect(self._draw)
        self.words = OneLine()
        self.key = having(Key(theme), wordWrap=True)
        self.plot = Plot(theme, "speed before the impact [m/s]", "e", left_px=_LEFT)
        choices = labelled("Against", self.against), self.against, labelled("Model", self.model), self.model
        top = fill(QHBoxLayout(), *choices, (self.words, 1), margins=(6, 3, 6, 0), spacing=6)
        fill(QVBoxLayout(self), top, self.key, (self.plot, 1), spacing=1)

    def show_facts(self, facts: ReportFacts | None) -> None:
        """Draw a series; None: there is none."""
        self._facts = facts
        self._draw()

    @property
    def fits(self) -> list[SpeedFit]:
        """What is drawn through the impacts, one a sample."""
        chosen, facts = self.model.currentData(), self._facts
        if facts is None:
            return []
        if chosen == _BEST:
            return shown_fits(facts)
        return [sample.fit(chosen) for sample in facts.findings.samples]

    def _draw(self, _index: int = 0) -> None:
        on = self.against.currentData()
        self.model.setEnabled(on == _SPEED)
        if on != _SPEED:
            self._draw_besides(on)
            return
        self.plot.take_all_out()
        self.plot.relabel("speed before the impact [m/s]", "e")
        groups = [speed_points(one.runs) for one in self._facts.sessions] if self._facts else []
        every = np.concatenate(groups, axis=1) if groups else np.empty((3, 0))
        found = self._facts.findings.sessions if self._facts else ()
        self.words.setText("; ".join(said_of(self._facts.findings, fit) for fit in self.fits) if self._facts else "")
        self.plot.when_empty = "" if every.size else "No valid impact yet."
        if not every.size:
            self.key.show_entries()
            return
        drawn = [fit for fit in self.fits if fit.parameters]
        for fit in drawn:
            speed = np.linspace(max(fit.speed_low_m_s, 1e-3), fit.speed_high_m_s, 80)
            e, u = fit.e(speed)
            self.plot.band("fit").show_band(speed, e - COVERAGE * u, e + COVERAGE * u)
            self.plot.band("fit").show_band(speed, e - fit.prediction(speed), e + fit.prediction(speed))
            self.plot.fast_line("fit", title_of(fit.model), dashed=True).setData(speed, e)
        for number, (speed, e, u) in enumerate(groups):
            name = found[number].name
            self.plot.bars(role_of(number), f"{name} ± {COVERAGE:g} u").show_bars(speed, e, COVERAGE * u)
            self.plot.marker(role_of(number), mark_of(number)[1], 6, name).setData(speed, e)
        low, high = e_span(every)
        n_outside = int(np.count_nonzero((every[1] < low) | (every[1] > high)))
        self.plot.setXRange(0.0, 1.08 * float(every[0].max()), padding=0)
        self.plot.setYRange(low, high, padding=0)
        titles = dict.fromkeys(title_of(fit.model) for fit in drawn)
        fitted = [("╌", "fit", f"{' / '.join(titles)} ± {COVERAGE:g} u; wider: one more impact, 95 %")] if drawn else []
        outside = [("", "text", f"{n_outside} outside")] if n_outside else []
        self.key.show_entries(("│", "text", f"± {COVERAGE:g} u"), *fitted, *session_key(found), *outside)
        self.key.setToolTip(_plain(session_key(found)))

    def _draw_besides(self, on: str) -> None:
        """Draw e against an angle, a diameter or the number of the drop, one colour a sample."""
        self.plot.take_all_out()
        samples = self._facts.findings.samples if self._facts else ()
        found = [(sample.label or UNNAMED, one) for sample in samples for one in sample.dependences if one.on == on]
        known = [(label, one) for label, one in found if not one.problem]
        covariate = COVARIATES[on]
        self.plot.relabel(covariate.label, e_label([one for _, one in known]) if known else covariate.of)
        self.words.setText("; ".join(f"{label}: {one.words}" if len(found) > 1 else one.words for label, one in found))
        why = "; ".join(dict.fromkeys(one.problem for _, one in found)) or "no impact yet"
        self.plot.when_empty = "" if known else sentence(why)
        if not known:
            self.key.show_entries()
            return
        entries = [("│", "text", f"± {COVERAGE:g} u"), ("╌", "fit", "line")]
        for number, (label, one) in enumerate(known):
            x, e, u = points_of(one)
            ends = np.array([x.min(), x.max()])
            self.plot.fast_line("fit", "line", dashed=True).setData(covariate.scale * ends, one.line(ends))
            bars = self.plot.bars(role_of(number), f"{label} ± {COVERAGE:g} u")
            bars.show_bars(covariate.scale * x, e, COVERAGE * u)
            self.plot.marker(role_of(number), mark_of(number)[1], 6, label).setData(covariate.scale * x, e)
            entries.append((mark_of(number)[0], role_of(number), label if len(known) > 1 else "valid impacts"))
        self.key.show_entries(*entries)
        self.plot.enableAutoRange()


class SpreadView(QWidget):
    """How e of the first impacts is distributed: p(e) of each session, of a single one its histogram too."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.key, self.words = having(Key(theme), wordWrap=True), PlainLabel()
        self.plot = Plot(theme, "e of the first impact", "p(e)", left_px=_LEFT)
        fill(QVBoxLayout(self), self.key, (self.plot, 1), self.words, spacing=1)

    def show_facts(self, facts: ReportFacts | None) -> None:
        """Draw a series; None: there is none."""
        self.plot.take_all_out()
        sessions = facts.findings.sessions if facts else ()
        shown = [(number, one.name, one.distribution) for number, one in enumerate(sessions) if one.distribution]
        self.plot.when_empty = "" if shown else "A distribution wants four drops whose e differs."
        several = len(sessions) > 1
        self.words.setText("\n".join(f"{name}: {one.words}" if several else one.words for _, name, one in shown))
        if not shown:
            self.key.show_entries()
            return
        for number, name, one in shown:
            self.plot.fast_line(role_of(number), f"p(e) of {name}").setData(np.array(one.at), np.array(one.density))
            if not several:
                self.plot.fast_line("text", "histogram").setData(*histogram_of(one))
                self.plot.rule("fit", one.prediction_low)
                self.plot.rule("fit", one.prediction_high)
        own = [("▬", "text", "histogram"), ("╌", "fit", "one more drop, 95 %")]
        looks = [("▬", role, words) for _, role, words in session_key(sessions)]
        self.key.show_entries(*(looks if several else [("▬", role_of(0), "p(e)"), *own]))
        self.plot.enableAutoRange()
        low, high = min(one.at[0] for *_, one in shown), max(one.at[-1] for *_, one in shown)
        if not several:
            # a rule does not widen the axis by itself
            low, high = min(low, shown[0][2].prediction_low), max(high, shown[0][2].prediction_high)
        self.plot.setXRange(low, high)


class FallsView(QWidget):
    """Way fallen of every run from the vertex of its parabola on, over the common one; what each fit leaves below."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.key = having(Key(theme), wordWrap=True)
        self.fallen = Plot(theme, "", "fall [mm]", left_px=_LEFT, figures_below=False)
        self.left = Plot(theme, "time from the vertex of the parabola [s]", "Δz [µm]", left_px=_LEFT)
        self.left.setToolTip("Height less the parabola fitted to each fall")
        self.fallen.setXLink(self.left)
        # downwards, as it falls
        self.fallen.getPlotItem().invertY(True)
        fill(QVBoxLayout(self), self.key, (self.fallen, 3), (self.left, 2), spacing=1)

    def show_facts(self, facts: ReportFacts | None) -> None:
        """Draw a series; None: there is none."""
        for plot in (self.fallen, self.left):
            plot.take_all_out()
        groups = [one.runs for one in facts.sessions] if facts else []
        runs = [run for group in groups for run in group if run.falls is not None]
        self.fallen.when_empty = "" if runs else "No fall was fitted yet."
        if facts is None or not runs:
            self.key.show_entries()
            return
        g, end = mean_gravity(runs), max(float(np.nanmax(run.falls[0].x)) for run in runs if run.falls)
        for number, group in enumerate(groups):
            # one curve a session: a hundred would take their time to draw
            for plot, part, scale in ((self.fallen, 0, 1e3), (self.left, 1, 1e6)):
                curves = [run.falls[part] for run in group if run.falls]
                x, y = ([np.append(getattr(one, axis), np.nan) for one in curves] for axis in "xy")
                if curves:
                    name = facts.findings.sessions[number].name
                    plot.fast_line(role_of(number), name).setData(np.concatenate(x), scale * np.concatenate(y))
                    if len(groups) == 1:
                        continue
                    # on each curve elsewhere, for they lie upon one another
                    at = [int(one.x.size * (number + 1) / (len(groups) + 1)) for one in curves]
                    places = [(one.x[n], scale * one.y[n]) for one, n in zip(curves, at, strict=True)]
                    plot.marker(role_of(number), mark_of(number)[1], 7).setData(*np.transpose(places))
        t = np.linspace(0.0, end, 100)
        # g t²/2 in mm, from the vertex, where the sphere would be at rest
        self.fallen.fast_line("fit", "g t²/2", dashed=True).setData(t, 500.0 * g * t**2)
        # of one session no place on its curves is marked
        key = session_key(facts.findings.sessions)
        named = [("▬" if len(groups) == 1 else sign, role, words) for sign, role, words in key]
        self.key.show_entries(("╌", "fit", f"g t²/2, g = {g:.4f} m/s²"), *named)
        self.key.setToolTip(_plain(session_key(facts.findings.sessions)))
        for plot in (self.fallen, self.left):
            plot.enableAutoRange()


def role_of(session: int) -> str:
    """Return the colour of a session of several."""
    return f"compared.{session_look(session)[0]}"


def mark_of(session: int) -> tuple[str, str]:
    """Return the sign of a session of several: as it stands in the key, and as pyqtgraph calls it."""
    return _SIGNS[session_look(session)[1]]


def session_key(sessions: Sequence[SessionFindings]) -> list[tuple[str, str, str]]:
    """Return what says which colour is which session, with its height of fall; of a single one nothing is named."""
    if len(sessions) == 1:
        return [(mark_of(0)[0], role_of(0), "drops that count")]
    names = [one.name for one in sessions]
    # of one day its time is enough
    cut = _DATE if names[0][_DATE - 1 : _DATE] == "T" and len({name[:_DATE] for name in names}) == 1 else 0
    return [
        (
            mark_of(number)[0],
            role_of(number),
            " ".join(filter(None, (one.name[cut:][:_LONGEST_NAME], _height(one.series.drop_height_m)))),
        )
        for number, one in enumerate(sessions)
    ]


def _plain(entries: list[tuple[str, str, str]]) -> str:
    return "\n".join(f"{sign} {words}" for sign, _, words in entries)


def _height(found: Statistics) -> str:
    return plain(found.mean, 3, "mm", 1e3) if found.n else ""


class SeriesPanel(QWidget):
    """Of the session that is open, and of those that it is compared with: statistics, what is drawn, what is said."""

    def __init__(self, runs: RunListPanel, does: Actions, services: Services) -> None:
        super().__init__()
        self._services = services
        self._others: tuple[Path, ...] = ()
        self._of: Path | None = None
        self._reads = OneAtATime(services.jobs, "the series", self.refresh)
        self.facts: ReportFacts | None = None
        self.table = RowTable(RowModel(COLUMNS, lambda _row: TIP), "series", many=True)
        empty = "What the series found is said here once runs have results."
        words = QPlainTextEdit(readOnly=True, placeholderText=empty)
        self.words = having(words, accessibleName="The series in words")
        self._stale = set[str]()
        views: dict[str, Callable[[Theme], QWidget]] = {"speeds": SpeedView, "spread": SpreadView, "falls": FallsView}
        later = {name: partial(view, services.theme) for name, view in views.items()}
        self.pages = Pages(_PAGES, later, table=self.table, words=self.words)
        self._title = OneLine("No session")
        self.compare = button("Compare sessions…", does.sessions.trigger)
        self.alone = button("Only this one", lambda: self.show_beside(()))
        top = fill(QHBoxLayout(), (self._title, 1), self.compare, self.alone, margins=(6, 3, 6, 0), spacing=6)
        fill(QVBoxLayout(self), top, (self.pages, 1), spacing=1)
        self.pages.currentChanged.connect(self._draw)
        runs.model.altered.connect(self.refresh)
        self.show_facts(None)

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Read what is new."""
        super().showEvent(event)
        self.refresh()

    def show_part(self, name: str) -> None:
        """Show one of the pages."""
        self.pages.turn_to(name)

    def show_beside(self, sessions: tuple[Path, ...]) -> None:
        """Show these sessions beside the one that is open; none: that one alone."""
        self._others = sessions
        self.refresh()

    def refresh(self) -> None:
        """Read what has changed, where it is seen; what comes meanwhile is read afterwards."""
        own, glances = self._services.control.session, self._services.glances
        path = own.path if own is not None else None
        if path != self._of:
            # nothing of the session before is left to be read off
            self._of = path
            self.show_facts(None, "Reading …")
        if not self.isVisible():
            self._reads.outdate()
            return
        others = [path for path in self._others if own is None or path != own.path]

        def work() -> ReportFacts | None:
            sessions = [*([own] if own else []), *(Session.open(path, write=False) for path in others)]
            return report_facts([glances.session_facts(one) for one in sessions], "") if sessions else None

        self._reads.start(work, self.show_facts, self._failed)

    def _failed(self, error: BaseException) -> None:
        self._services.board.post_error(error)
        compared, self._others = self._others, ()
        if compared:
            self.refresh()
        else:
            self.show_facts(None, "The session cannot be read: see the message")

    def _draw(self, _index: int = 0) -> None:
        if (name := self.pages.shown) in self._stale:
            self._stale.discard(name)
            self.pages.page(name).show_facts(self.facts)

    def show_facts(self, facts: ReportFacts | None, nothing: str = "No session") -> None:
        """Show what one session or several found; None: there is `nothing`."""
        self.facts = facts
        found = facts.findings.sessions if facts else ()
        self.table.setColumnHidden(0, len(found) < 2)
        self.table.show_rows(row for one in found for row in rows_of(one))
        self.alone.setVisible(len(found) > 1)
        kind = f"{found[0].series.mark}, " if found and found[0].series.mark else ""
        n_runs = sum(len(one.runs) for one in facts.sessions) if facts else 0
        named = ", ".join(one.name for one in found)
        n_preliminary = sum(len(one.preliminary) for one in found)
        preliminary = f", {n_preliminary} preliminary" if n_preliminary else ""
        self._title.setText(f"{named}: {kind}{counted(n_runs, 'run')}{preliminary}" if found else nothing)
        self._stale = {"speeds", "spread", "falls"}
        self._draw()
        self.words.setPlainText("\n\n".join(_said(facts)) if facts and n_runs else "")


def _said(facts: ReportFacts) -> list[str]:
    """Return what the first page of the report says, and which runs are not in the mean."""
    found = facts.findings
    compared = [one.words for one in (found.samples_compared, found.sessions_compared) if one is not None]
    out = [
        f"Not in the mean of e, {one.name}: {run.run} ({run.kind}): {run.reason or UNKNOWN}"
        for one in found.sessions
        for run in one.excluded
    ]
    fits = [said_of(found, fit) for sample in found.samples for fit in sample.fits if fit.n_impacts]
    said = (found.sentence, *(f"{words}." for words in compared), *found.cautions, *out, *fits)
    said = (*said, *(f"{one.words}." for sample in found.samples for one in sample.dependences if not one.problem))
    spread = (f"Distribution of e, {one.name}: {one.distribution.words}." for one in found.sessions if one.distribution)
    return [with_powers(one) for one in (*said, *spread)]


def said_of(found: Findings, fit: SpeedFit) -> str:
    """Return what a fit says; of several samples with the name of the one that it is of."""
    of = next((one.label for one in found.samples if any(fit is own for own in one.fits)), "")
    return f"{of or UNNAMED}: {fit.words}" if len(found.samples) > 1 else fit.words
