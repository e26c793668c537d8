"""The uncertainty of corrections that give one number a receiver."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.draw import draw as draw_world
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.scene import make_record
from benchmarks.world.scene import make_record as make_world_record
from support.changed import changed

from radargui.processing.process import process


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


@pytest.mark.parametrize(
    ("method", "motion", "first"),
    [
        ("published", "drop", 555005),
        ("adaptive", "drop", 555018),
        pytest.param("adaptive", "pendulum", 555105, marks=pytest.mark.slow),
    ],
)
def test_circles_each_by_itself_are_as_uncertain_as_reflections_make_them(method: str, motion: str, first: int) -> None:
    # rooms whose floors send back 5 to 30 % of the wave, which turns a phase as much as it lengthens the phasor
    over_u = []
    for seed in range(first, first + 5):
        record = make_world_record(draw_world(seed, "exact", motion=motion))
        result = process(record.recording, changed(record.scene.setup, processing={"correction": method}))
        assert result.track is not None
        used = result.track.valid & (result.track.time_s > record.scene.drop.start_s)
        error = (result.track.position_m - record.truth.position_m)[:, used]
        over_u.append(np.abs(error / result.track.u_position_m[:, used])[:, :: used.sum() // 500])
    ratio = np.concatenate(over_u, axis=1)
    assert (ratio < 2.0).mean() > 0.95
    # too large would hold it as well
    assert np.sqrt((ratio**2).mean()) > 0.3
