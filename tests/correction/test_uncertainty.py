"""The uncertainty of corrections that give one number a receiver."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.scenes.draw import draw_scene
from benchmarks.scenes.scene import make_record
from support.changed import changed

from radargui.processing.offline import process


@pytest.mark.parametrize(("seed", "kind"), [(9201, "generic"), (9202, "physical"), (9204, "generic")])
def test_an_echo_that_grows_leaves_the_ellipse_uncertain_by_more_than_each_fringe_shows(seed: int, kind: str) -> None:
    record = make_record(draw_scene(seed, kind, None))
    result = process(record.recording, changed(record.setup, processing={"correction": "ellipse"}))
    assert result.track is not None
    assert result.corrected is not None
    inside = np.abs(result.track.position_m - record.truth.position_m) < 2 * result.track.u_position_m
    assert inside[:, result.track.valid].mean() > 0.95
    shown = [channel.circularity or 0.0 for channel in result.corrected.channels]
    assert (np.nanmedian(result.corrected.u_phase_rad, axis=1) >= 0.999 * np.array(shown)).all()
