"""The track of a run that is analysed: one part of the panel of the track at a time."""

from __future__ import annotations

from typing import cast, get_args

from radargui.gui.track.track_curves import Detail
from radargui.gui.track.track_panel import TrackPanel
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult


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
