"""What is said of a fall that ends in grains, on something hard, or on what gives way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from radargui.model.arrays import FloatArray
from radargui.model.result import Bounce, Bounces, FreeFall, Track
from radargui.restitution.stopped_fall import braked_without_impact


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
    finding = braked_without_impact(*sunk(depth_m))
    assert (finding is not None) == told
    assert finding is None or f"{1e3 * depth_m:.0f} mm deeper" in finding.text


def fell_until(end_s: float, height_m: Callable[[FloatArray], FloatArray]) -> tuple[Bounces, Track]:
    """A fall whose fit ends 12 ms before something happens at 0.2 s, and the height from there on."""
    bounces, track = sunk(0.0)
    z = np.where(track.time_s < end_s, -4.9 * track.time_s**2, -4.9 * end_s**2 + height_m(track.time_s - end_s))
    assert bounces.free_fall is not None
    fall = replace(bounces.free_fall, last_time_s=end_s - 0.012)
    return replace(bounces, free_fall=fall), replace(track, position_m=np.stack([0.0 * z, 0.0 * z, z]))


def test_a_dead_stop_on_something_hard_is_no_fall_into_grains() -> None:
    assert braked_without_impact(*fell_until(0.2, np.zeros_like)) is None


def test_what_throws_the_sphere_up_again_softly_is_not_called_the_end_without_a_rebound() -> None:
    def gives_way(since_s: FloatArray) -> FloatArray:
        contact_s, out_m_s = 0.015, 1.5
        down = -1.96 * contact_s / np.pi * np.sin(np.pi * np.clip(since_s / contact_s, 0.0, 1.0))
        up_s = np.maximum(since_s - contact_s, 0.0)
        return down + np.maximum(out_m_s * up_s - 4.9 * up_s**2, 0.0)

    finding = braked_without_impact(*fell_until(0.2, gives_way))
    assert finding is not None
    assert "without a rebound" not in finding.text
    assert "braked over 7 mm and thrown up again by 124 mm" in finding.text


def test_after_a_rebound_without_a_fall_or_unseen_nothing_is_said() -> None:
    bounces, track = sunk(0.03)
    impact = Bounce(0.2, 2.0, 1.0, 0.5, 1e-3, "made", valid=True)
    assert braked_without_impact(replace(bounces, impacts=(impact,)), track) is None
    assert braked_without_impact(Bounces(), track) is None
    assert braked_without_impact(bounces, replace(track, valid=track.time_s < 0.2)) is None
