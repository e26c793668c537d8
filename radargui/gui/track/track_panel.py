"""The panel of the track: in space or in projections, the height against time, where the sphere is now."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import QLabel, QSizePolicy, QSplitter, QStackedWidget, QVBoxLayout, QWidget

from radargui.gui.control.feed import Feed
from radargui.gui.layout import fill
from radargui.gui.plots.plot import Key
from radargui.gui.theme import Theme
from radargui.gui.track.flat_views import HeightPlot, Projections
from radargui.gui.track.shown_track import LiveTrail, ShownTrack, Space, result_track, space_of
from radargui.model.result import RunResult
from radargui.model.setup import Setup

if TYPE_CHECKING:
    from radargui.gui.track.space_view import SpaceView

LIVE_S = 4.0
"""Of the live track: a drop of half a metre with its first ten bounces."""
HOLD_S = 0.8
"""A result stays so long at least, whatever moves: the hand that puts the sphere back comes a moment later."""


class TrackPanel(QWidget):
    """Shows the live trail; after a run its result, until something moves again."""

    def __init__(self, theme: Theme, setup: Setup) -> None:
        super().__init__()
        self._theme = theme
        self._space: Space = space_of(setup)
        self._trail: LiveTrail | None = None
        self.shown: ShownTrack | None = None
        self._held_until = 0.0
        self.result_shown = False
        self.paused = False

        self._stack = QStackedWidget()
        self.projections = Projections(theme)
        self._stack.addWidget(self.projections)
        self._space_view: SpaceView | None = None
        self.height_plot = HeightPlot(theme, LIVE_S)
        self.where = QLabel()
        self.where.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        self.where.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.where.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.key = Key(theme)
        for label in (self.where, self.key):
            label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self._title = QLabel()
        self._title.setContentsMargins(6, 3, 6, 0)

        lower = QWidget()
        fill(QVBoxLayout(lower), self.where, self.key, (self.height_plot, 1))
        splitter = QSplitter(Qt.Orientation.Vertical)
        splitter.setObjectName("track.parts")
        splitter.addWidget(self._stack)
        splitter.addWidget(lower)
        splitter.setStretchFactor(0, 3)
        splitter.setStretchFactor(1, 2)
        splitter.setChildrenCollapsible(False)
        fill(QVBoxLayout(self), self._title, (splitter, 1), spacing=0)
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

    def use_space_view(self, wanted: bool) -> None:
        """Show the track in space; only where the test of OpenGL said yes."""
        if wanted == self.in_space:
            return
        if wanted:
            from radargui.gui.track.space_view import SpaceView

            self._space_view = SpaceView(self._theme)
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
            camera = self._space_view.camera()
            self.use_space_view(False)
            self.use_space_view(True)
            self._space_view.take_camera(camera)

    def show_setup(self, setup: Setup) -> None:
        """Show the field of view of another setup."""
        self._space = space_of(setup)
        for view in (self.view, self.height_plot):
            view.show_space(self._space)

    def show_feed(self, feed: Feed | None) -> None:
        """Follow another acquisition; None keeps what is shown."""
        self._trail = None if feed is None else LiveTrail(feed, LIVE_S)
        if feed is not None:
            self.show_setup(feed.setup)
        self._follow()

    def show_result(self, result: RunResult, name: str) -> None:
        """Show what a run gave instead of the live track."""
        track = result_track(result)
        self.result_shown = True
        self._held_until = time.monotonic() + HOLD_S
        self.show_setup(result.setup)
        self._draw(track)
        self.height_plot.show_result(track)
        words = "preliminary result" if result.preliminary else "result"
        self._entitle(f"{name}: {words if track else 'no track'}")
        drawn = [("▬", "track", "z")] if track else []
        drawn += [("╌", "fit", "parabola of the first fall")] if track and track.fit_time_s.size else []
        drawn += [("×", "mark", "impacts")] if track and track.impact_time_s.size else []
        self.key.show_entries(*drawn)
        self._show_words(result=track is not None)

    def clear(self) -> None:
        """Forget the result that was shown, and the last moments of the live track."""
        self.show_live()
        self._draw(None)
        self.height_plot.show_live(None)
        self._entitle("Live track: nothing yet")
        self._show_words(result=False)
        self._show_where(None)

    def show_live(self) -> None:
        """Go back to the live track."""
        self._held_until = 0.0
        self.result_shown = False

    def set_paused(self, paused: bool) -> None:
        """Hold the picture, or let it go on."""
        self.paused = paused
        self._follow()

    def refresh(self) -> None:
        """Draw the newest of the trail; called by the window's timer."""
        if self._trail is None or self.paused:
            return
        track = self._trail.pull()
        if track is None:
            return
        if self.result_shown and (time.monotonic() < self._held_until or not self._trail.moving):
            return
        self.result_shown = False
        self._show_words(result=False)
        anew = "starts anew after lost samples, as if from the release" if self._trail.began_anew else ""
        rest = "" if self._trail.moving else "at rest"
        self._entitle(": ".join(filter(None, ("Live track", ", ".join(filter(None, (rest, anew)))))))
        if not self.isVisible():
            return
        self._draw(track)
        self.height_plot.show_live(track)
        self._show_where(track)

    def _follow(self) -> None:
        self.height_plot.follow(self._trail is not None and not self.paused)

    def _draw(self, track: ShownTrack | None) -> None:
        self.shown = track
        self.view.show_track(track)

    def _entitle(self, words: str) -> None:
        if self._title.text() != words:
            self._title.setText(words)

    def _show_words(self, *, result: bool) -> None:
        self.where.setVisible(not result)
        self.key.setVisible(result)

    def _show_where(self, track: ShownTrack | None) -> None:
        # short enough for the narrowest dock
        text = "x       –  y       –  z       –  mm"
        if track is not None and track.position_mm.shape[1]:
            place = track.position_mm[:, -1]
            if np.isfinite(place).all():
                text = "  ".join(f"{axis} {value:+7.1f}" for axis, value in zip("xyz", place, strict=True)) + "  mm"
        self.where.setText(text)
