"""The panel of the track: in space or in projections, coloured by speed; its curves; where the sphere is now."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, cast, get_args

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QSplitter, QStackedWidget, QVBoxLayout, QWidget

from radargui.acquisition.envelope import thin
from radargui.gui.background import StartWork
from radargui.gui.control.state import Feed
from radargui.gui.layout import Turning, boxed, fill, having, holding
from radargui.gui.plots.key import ColourBar
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme, even_font, scaled_px
from radargui.gui.track.shown_track import (
    MM,
    NO_TRACK,
    ShownTrack,
    Space,
    live_track,
    result_track,
    space_of,
)
from radargui.gui.track.speed_colours import SpeedColours, SpeedTrail
from radargui.gui.track.track_curves import Detail, TrackCurves
from radargui.live.impacts import LiveImpacts
from radargui.live.track import LiveTrack
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult
from radargui.model.rounding import UNKNOWN, with_sign
from radargui.model.setup import Setup
from radargui.physics.path_length import MIN_RECEIVERS

if TYPE_CHECKING:
    from radargui.gui.track.space_view import SpaceView


_AXES = "xyz"
_VIEWS = ((0, 2), (1, 2), (0, 1))
"""Axis to the right and axis upwards of each: x-z, y-z, x-y."""
_LEFT = 50
"""Width of the left axes in pixels (chosen by hand): in less a low plot writes its words upon its figures."""


class Projections(QWidget):
    """x-z, y-z and x-y, the same scale on both axes of each."""

    def __init__(self, theme: Theme, colours: SpeedColours) -> None:
        super().__init__()
        self._colours = colours
        self.plots: list[Plot] = []
        self._parts = []
        for across, up in _VIEWS:
            words = f"{_AXES[across]} [mm]", f"{_AXES[up]} [mm]"
            plot = Plot(theme, *words, left_px=_LEFT, equal=True, live=True, density=0.6)
            floor = plot.rule("line", 0.0, angle=0, dashed=False) if up == 2 else None
            trail = SpeedTrail(colours)
            plot.addItem(trail)
            impacts = plot.marker("mark", symbol="x", size=9, name="impacts")
            sphere = plot.dot("text")
            self.plots.append(plot)
            self._parts.append((across, up, plot, floor, trail, impacts, sphere))
        fill(QHBoxLayout(self), *self.plots)

    def show_space(self, space: Space) -> None:
        """Show another field of view."""
        for across, up, plot, floor, *_ in self._parts:
            x, y = np.stack([space.low_mm, space.high_mm])[:, [across, up]].T
            plot.setRange(xRange=x, yRange=y, padding=0)
            if floor is not None:
                floor.setValue(space.floor_mm)

    def show_track(self, track: ShownTrack) -> None:
        """Draw a track."""
        pieces, place = self._colours.pieces(track), track.position_mm
        for across, up, _, _, trail, impacts, sphere in self._parts:
            trail.show_trail(place[across], place[up], pieces)
            impacts.setData(track.impact_mm[across], track.impact_mm[up])
            sphere.show_at(track.sphere_mm[across], track.sphere_mm[up])

    def show_sphere(self, place_mm: FloatArray) -> None:
        """Draw the sphere elsewhere, shape (3, 1)."""
        for across, up, *_, sphere in self._parts:
            sphere.show_at(place_mm[across], place_mm[up])


_MAX_LIVE_POINTS = 1500
"""One each 2.7 ms of `LIVE_S`: 8 mm at the 3.1 m/s of a drop of half a metre."""
LIVE_S = 4.0
"""Of the live track: a drop of half a metre with its first ten bounces."""
MIN_REST_S = 0.25
"""What is quiet for less is a sphere that turns round at the top of a bounce: chosen by hand."""
HOLD_S = 0.8
"""A result stays so long at least, whatever moves: the hand that puts the sphere back comes a moment later."""


_BESIDE = 620
"""Pixels from which the view stands beside the curve below the height: three projections need as many."""
_SHARES = (67, 33)
"""Of the height against time, and of what stands below it."""


TOO_FEW = f"No track: a position needs {MIN_RECEIVERS} receivers."


class TrackPanel(QWidget):
    """Shows the live trail; after a run its result, until something moves again.

    Parameters
    ----------
    theme, setup
        Look; field of view at first.
    start
        Runs work away from the thread that draws, see `Jobs.start`.

    Attributes
    ----------
    result
        What is shown; None: the live track.
    """

    def __init__(self, theme: Theme, setup: Setup, start: StartWork) -> None:
        super().__init__()
        self._theme, self._start = theme, start
        self._feed: Feed | None = None
        self._drawn = -1
        self._moved: int | None = None
        self._impacts = LiveImpacts(1.0)
        self.shown: ShownTrack | None = None
        self.result: RunResult | None = None
        self._held_until = 0.0
        self.paused = False

        self._colours = SpeedColours(theme)
        self.speed_bar = ColourBar("Colour of the trail: speed of the sphere in m/s")
        self.speed_bar.setFixedWidth(self.fontMetrics().horizontalAdvance("0  10.0 m/s ") + 64)
        theme.changed.connect(self._show_colours)
        self.projections = Projections(theme, self._colours)
        self._stack = holding(QStackedWidget(), self.projections)
        self._space_view: SpaceView | None = None
        selectable = Qt.TextInteractionFlag.TextSelectableByMouse
        self.where = QLabel(alignment=Qt.AlignmentFlag.AlignHCenter, textInteractionFlags=selectable)
        self.where.setFont(even_font(self.where.font()))
        self.where.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.curves = TrackCurves(theme, LIVE_S, self.where)
        self._title = QLabel()
        self._title.setContentsMargins(6, 3, 6, 0)

        self._view = boxed(QVBoxLayout(), (self._stack, 1), fill(QHBoxLayout(), 1, self.speed_bar), spacing=0)
        self._lower = Turning(scaled_px(_BESIDE), (self._view, 3, 3), (self.curves.below, 2, 2))
        splitter = holding(QSplitter(Qt.Orientation.Vertical, childrenCollapsible=False), self.curves, self._lower)
        for place, share in enumerate(_SHARES):
            splitter.setStretchFactor(place, share)
        having(splitter, objectName="track.heights", sizes=[100 * share for share in _SHARES])
        said = Turning(scaled_px(_BESIDE), (self._title, 0, 1), (self.curves.words, 0, 1))
        fill(QVBoxLayout(self), said, (splitter, 1), spacing=0)
        self.show_setup(setup)
        self.clear()

    @property
    def in_space(self) -> bool:
        """Whether the OpenGL view is shown."""
        return self._space_view is not None

    @property
    def view(self) -> SpaceView | Projections:
        """The view in space, or the projections."""
        return self._space_view or self.projections

    def show_only(self, part: str) -> None:
        """Show one part alone: "height", "space" or "curve"; which run it is of is said elsewhere then."""
        self._title.hide()
        self.curves.tabs.hide()
        parts = {"height": (self.curves, self.curves.words), "space": (self._view,), "curve": (self.curves.below,)}
        for name, widgets in parts.items():
            for widget in widgets:
                widget.setVisible(part == name)
        self._lower.setVisible(part != "height")

    def use_space_view(self, wanted: bool) -> None:
        """Show the track in space; only where the test of OpenGL said yes."""
        if wanted == self.in_space:
            return
        if wanted:
            from radargui.gui.track.space_view import SpaceView

            self._space_view = SpaceView(self._theme, self._colours, self._space)
            self._stack.addWidget(self._space_view)
            self._stack.setCurrentIndex(1)
        elif self._space_view is not None:
            # not kept: as long as it exists the whole window is put together by OpenGL
            self._stack.setCurrentIndex(0)
            self._stack.removeWidget(self._space_view)
            self._space_view.deleteLater()
            self._space_view = None
        self.view.show_space(self._space)
        self._draw(self.shown)

    def renew_space_view(self) -> None:
        """Make the view in space anew: torn off or put back, its old surface stays black."""
        if self._space_view is not None:
            before = self._space_view
            self.use_space_view(False)
            self.use_space_view(True)
            self._space_view.look_as(before)

    def show_setup(self, setup: Setup) -> None:
        """Show the field of view of another setup."""
        self._setup, self._space = setup, space_of(setup)
        self._colours.fit(self._space)
        self._show_colours()
        for view in (self.view, self.curves.height_plot):
            view.show_space(self._space)
        if self.result is None:
            self._say_why_empty()

    def show_feed(self, feed: Feed | None) -> None:
        """Follow another acquisition; None keeps what is shown."""
        self._feed, self._drawn, self._moved = feed, -1, None
        if feed is not None:
            self._impacts = LiveImpacts(feed.rate_hz)
            self.show_setup(feed.setup)
        self._follow()

    def show_result(self, result: RunResult, name: str) -> None:
        """Show what a run gave instead of the live track, which stands still until it is drawn."""
        self.result = result
        self._held_until = time.monotonic() + HOLD_S
        what = "preliminary result" if result.preliminary else "result"

        def show(track: ShownTrack | None) -> None:
            self._title.setText(f"{name}: {'no track' if track is None else what}")
            self.curves.height_plot.when_empty = "" if track else _why_none(result)
            # at once, for each part of it would draw everything anew; and axes only where they change
            if result.setup != self._setup:
                self.show_setup(result.setup)
            self._colours.fit(self._space, track)
            self._show_colours()
            self._draw(track)
            self.curves.show_result(track)

        self._start("the track of the run", lambda: result_track(result), show, None, lambda: self.result is result)

    def clear(self) -> None:
        """Forget the result that was shown, and the last moments of the live track."""
        self.show_live()
        self._draw(None)
        self.curves.show_live(NO_TRACK)
        self._title.setText("Live track: nothing yet")
        self._show_where(np.full(3, np.nan))

    def show_live(self) -> None:
        """Go back to the live track."""
        self.result = None
        self._say_why_empty()

    def set_paused(self, paused: bool) -> None:
        """Hold the picture, or let it go on."""
        self.paused = paused
        self._follow()

    def refresh(self) -> None:
        """Draw the newest of the trail; called by the window's timer."""
        feed = self._feed
        live = feed.live if feed is not None else None
        if feed is None or live is None or self.paused or live.latest == self._drawn:
            return
        self._drawn = live.latest
        if live.moving:
            self._moved = self._drawn
        rests = self._moved is None or self._drawn - self._moved >= feed.samples(MIN_REST_S)
        span = live.since(max(0, self._drawn - feed.samples(LIVE_S)))
        held = self.result is not None and (time.monotonic() < self._held_until or not live.moving)
        if held or not span.index.size:
            return
        self.show_live()
        anew = "starts anew, as if from the release" if live.began_anew else ""
        # of a place that is not known nobody says that it is at rest there
        said = (f"place unknown, {live.doubt}",) if live.doubt else ("at rest" if rests else "", anew)
        now = ", ".join(filter(None, said))
        self._title.setText(f"Live track: {now}" if now else "Live track")
        if self.isVisible():
            rows: FloatArray = thin(np.vstack([span.index[None], span.position_m]), _MAX_LIVE_POINTS)
            track = live_track((rows[0] - self._drawn) / feed.rate_hz, rows[1:])
            track = self._with_events(track, feed, live)
            self._draw(track)
            self.curves.show_live(track)
            self._show_where(track.position_mm[:, -1])

    def _with_events(self, track: ShownTrack, feed: Feed, live: LiveTrack) -> ShownTrack:
        """Return the trail with what is drawn beside its places: impacts, and what the trigger saw."""
        self._impacts.look(live, self._space.gravity_m_s2)
        first = self._drawn - feed.samples(LIVE_S)
        seen = self._impacts.found[:, self._impacts.found[0] >= first]
        index, shaking = live.shaken_since(first)
        at_s, looked_s = ((one - self._drawn) / feed.rate_hz for one in (seen[0], index))
        return replace(track, impact_time_s=at_s, impact_mm=MM * seen[1:], shaken=np.stack([looked_s, shaking]))

    def _say_why_empty(self) -> None:
        """Say in the empty plot that there will be no track; where there can be one, what to do."""
        few = self._setup.n_receivers < MIN_RECEIVERS
        self.curves.height_plot.when_empty = TOO_FEW if few else ""

    def _show_colours(self) -> None:
        """Show the colours of the look, and the speed that they reach."""
        self.speed_bar.show_ends(self._colours.table(), "0", f"{self._colours.max_m_s:g} m/s")

    def _follow(self) -> None:
        self.curves.follow(self._feed is not None and not self.paused)

    def _draw(self, track: ShownTrack | None) -> None:
        self.shown = track
        self.view.show_track(track or NO_TRACK)

    def _show_where(self, place_mm: FloatArray) -> None:
        # short enough for the narrowest dock
        known = bool(np.isfinite(place_mm).all())
        words = (
            f"{axis} {with_sign(value, 1) if known else UNKNOWN:>7}"
            for axis, value in zip(_AXES, place_mm, strict=True)
        )
        self.where.setText("  ".join((*words, "mm")))


def _why_none(result: RunResult) -> str:
    if result.status == "no_motion":
        return "Nothing moved in this run."
    if result.setup.n_receivers < MIN_RECEIVERS:
        return TOO_FEW
    return "No track was found in this run."


class ResultTrack(TrackPanel):
    """Shows what a run gave, never what comes in: the height, the track in space, or one curve of it."""

    def show_part(self, name: str) -> None:
        """Show "height", "space" or one of the curves alone."""
        is_curve = name in get_args(Detail)
        if is_curve:
            self.curves.choose_of_result(cast("Detail", name))
        self.show_only("curve" if is_curve else name)

    def show_result(self, result: RunResult, name: str = "") -> None:
        """Show what a run gave."""
        super().show_result(result, name)

    def show_sphere(self, place_mm: FloatArray) -> None:
        """Draw the sphere elsewhere on its track, shape (3, 1)."""
        self.view.show_sphere(place_mm)
