"""What is said of a fall into grains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radargui.model.result import Bounce, Bounces, FreeFall, Track
from radargui.restitution.stopped_fall import braked_without_rebound


def sunk(depth_m: float) -> tuple[Bounces, Track]:
    """A fall until 0.2 s that then goes on for a depth, evenly braked within 50 ms."""
    time = np.arange(1000) / 1000.0
    share = np.clip((time - 0.2) / 0.05, 0.0, 1.0)
    z = -4.9 * np.minimum(time, 0.2) ** 2 - depth_m * (1.0 - (1.0 - share) ** 2)
    position = np.stack([0.0 * z, 0.0 * z, z])
    known = np.ones(time.size, dtype=np.bool_)
    fall = FreeFall(9.81, 0.01, 0.0, 0.2, 0.0, float("nan"), (0.0, 0.0, -4.9), 1e-5)
    return Bounces((), fall, (0.0, 0.0, 1.0)), Track(time, position, 0.0 * position + 1e-5, known, "exact")


@pytest.mark.parametrize(("depth_m", "told"), [(0.03, True), (0.004, True), (0.0005, False)])
def test_a_fall_that_is_braked_on_some_way_may_have_ended_in_grains(depth_m: float, *, told: bool) -> None:
    sentences = braked_without_rebound(*sunk(depth_m))
    assert len(sentences) == told
    assert all(f"{1e3 * depth_m:.0f} mm deeper" in one for one in sentences)


def test_after_a_rebound_without_a_fall_or_unseen_nothing_is_said() -> None:
    bounces, track = sunk(0.03)
    impact = Bounce(0.2, 2.0, 1.0, 0.5, 1e-3, "made", valid=True)
    assert braked_without_rebound(replace(bounces, impacts=(impact,)), track) == []
    assert braked_without_rebound(Bounces(), track) == []
    assert braked_without_rebound(bounces, replace(track, valid=track.time_s < 0.2)) == []
