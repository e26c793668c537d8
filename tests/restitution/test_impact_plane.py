"""Impacts on a floor that keeps its place, and on others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radargui.model.finding import Finding
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2
from radargui.model.result import Bounce, Bounces, Track
from radargui.restitution.impact_plane import judged_by_floor

RATE_HZ, G, SPEED = 10_000.0, 9.80665, 2.0
IMPACTS_S = np.array([0.3, 0.6, 0.85, 1.0])


def dropped(floor_m: np.ndarray, aside_m: np.ndarray, u_m: float = 1e-5) -> tuple[Bounces, Track]:
    """A track that falls with 2 m/s onto a floor whose height at each impact is given."""
    time = np.arange(11_000) / RATE_HZ
    number = np.minimum(np.searchsorted(IMPACTS_S, time), IMPACTS_S.size - 1)
    left = IMPACTS_S[number] - time
    z = floor_m[number] + SPEED * left - G * left**2 / 2.0
    position = np.stack([aside_m[number], np.zeros(time.size), z])
    known = np.ones(time.size, dtype=np.bool_)
    track = Track(time, position, np.full((3, time.size), u_m), known, "exact")
    impacts = tuple(Bounce(at, SPEED, 1.6, 0.8, 1e-3, "made", valid=True) for at in IMPACTS_S.tolist())
    return Bounces(impacts, None, (0.0, 0.0, 1.0), 0.1), track


def off_one_plane(bounces: Bounces, track: Track) -> list[Finding]:
    """What is said of the floor where no rebound is too fast: e stays what it is."""
    judged, findings = judged_by_floor(bounces, track, G_M_S2)
    assert judged == bounces
    return findings


LEVEL, TOGETHER = np.zeros(4), np.zeros(4)


@pytest.mark.parametrize("floor_mm", [[0.0, 0.2, 0.0, 0.0], [0.1, -0.1, 0.1, -0.1]])
def test_impacts_at_other_heights_are_told_with_what_they_are_off(floor_mm: list[float]) -> None:
    bounces, track = dropped(1e-3 * np.array(floor_mm), TOGETHER)
    (finding,) = off_one_plane(bounces, track)
    off = 1e3 * np.abs(np.array(floor_mm) - np.mean(floor_mm)).max() / 1e3
    assert f"up to {off:.2g} mm off one plane" in finding.text


def test_a_flat_floor_is_not_mentioned_nor_what_the_track_does_not_know() -> None:
    noise = 1e-5 * np.random.default_rng(4).standard_normal(4)
    assert off_one_plane(*dropped(LEVEL + noise, TOGETHER)) == []
    bumps = 2e-4 * np.array([0.0, 1.0, 0.0, 1.0])
    assert off_one_plane(*dropped(bumps, TOGETHER, u_m=2e-4)) == []
    # an error that belongs to the place is the same in all of them
    assert judged_by_floor(*dropped(bumps, TOGETHER, u_m=2e-4), gravity_m_s2=G_M_S2, alike_m=2.4e-3)[1]
    far = np.array([0.0, 0.01, -0.01, 0.02])
    assert judged_by_floor(*dropped(bumps, far, u_m=2e-4), gravity_m_s2=G_M_S2, alike_m=2.4e-3)[1] == []


def test_a_slope_within_what_is_known_of_the_normal_is_no_step() -> None:
    aside = np.array([0.0, 0.01, 0.02, 0.03])
    bounces, track = dropped(np.tan(np.radians(0.3)) * aside, aside)
    assert off_one_plane(bounces, track) == []
    assert off_one_plane(replace(bounces, u_tilt_deg=0.01), track)
    # along the slope it is a plane, and nothing else is
    bent = np.tan(np.radians(0.3)) * aside + 3e-4 * np.array([0.0, 1.0, 0.0, 0.0])
    assert off_one_plane(*dropped(bent, aside))


def test_speed_along_the_floor_that_turns_away_from_it_is_no_floor_that_moves() -> None:
    bounces, track = dropped(np.array([0.0, 5e-4, 5e-3, 0.0]), TOGETHER)
    grazing = replace(bounces.impacts[1], speed_after_m_s=2.1, e=1.05, u_e=0.01, vt_before_m_s=3.0, vt_after_m_s=2.6)
    for along, words in ((2.6, "off one plane"), (3.2, "the floor moves")):
        impact = replace(grazing, vt_after_m_s=along)
        impacts = (bounces.impacts[0], impact, *bounces.impacts[2:])
        judged, (finding,) = judged_by_floor(replace(bounces, impacts=impacts), track, G_M_S2)
        assert words in finding.text
        assert judged.impacts[1].valid == (words == "off one plane")


@pytest.mark.parametrize("valid", [True, False])
def test_a_floor_that_gives_speed_gives_no_restitution(*, valid: bool) -> None:
    bounces, track = dropped(np.array([0.0, 5e-4, 5e-3, 0.0]), TOGETHER)
    faster = replace(bounces.impacts[1], speed_after_m_s=2.1, e=1.05, u_e=0.01, valid=valid)
    moved = replace(bounces, impacts=(bounces.impacts[0], faster, *bounces.impacts[2:]))
    judged, (finding,) = judged_by_floor(moved, track, G_M_S2)
    assert not any(impact.valid for impact in judged.impacts)
    assert "after impact 2" in finding.text
    # not beyond its uncertainty, or on a floor that keeps its place
    unsure = replace(moved, impacts=(bounces.impacts[0], replace(faster, u_e=0.02), *bounces.impacts[2:]))
    assert off_one_plane(unsure, track)
    assert off_one_plane(moved, dropped(LEVEL, TOGETHER)[1]) == []


def test_what_hardly_bounces_or_is_not_seen_has_no_say() -> None:
    bounces, track = dropped(np.array([0.0, 0.0, 5e-3, 0.0]), TOGETHER)
    assert off_one_plane(bounces, track)
    impacts = list(bounces.impacts)
    impacts[2] = replace(impacts[2], speed_after_m_s=0.05, e=0.025)
    assert off_one_plane(replace(bounces, impacts=tuple(impacts)), track) == []
    unseen = track.valid & ~((track.time_s > 0.8) & (track.time_s < 0.85))
    assert off_one_plane(bounces, replace(track, valid=unseen)) == []
    assert off_one_plane(replace(bounces, impacts=bounces.impacts[:1]), track) == []
    assert off_one_plane(Bounces(), track) == []


def test_a_last_impact_that_gives_no_e_is_no_place_on_the_floor_but_one_between_others_is() -> None:
    bounces, track = dropped(1e-3 * np.array([0.0, 0.0, 0.0, 0.2]), TOGETHER)
    assert off_one_plane(bounces, track)
    *others, last = bounces.impacts
    # several small bounces that are not told apart
    assert off_one_plane(replace(bounces, impacts=(*others, replace(last, e=2.1, valid=False))), track) == []
    bounces, track = dropped(1e-3 * np.array([0.0, 0.2, 0.0, 0.0]), TOGETHER)
    first, second, *others = bounces.impacts
    assert off_one_plane(replace(bounces, impacts=(first, replace(second, valid=False), *others)), track)
    # laboratory twice 24020998: it lay then, and a hand dropped it again
    lay = replace(second, speed_after_m_s=0.15, e=0.08, valid=False)
    assert off_one_plane(replace(bounces, impacts=(first, lay, *others)), track) == []


def test_impacts_after_the_last_valid_one_that_throw_the_sphere_lie_on_the_floor_that_moves() -> None:
    bounces, track = dropped(1e-3 * np.array([0.0, 3.0, -3.0, 0.0]), TOGETHER)
    first, *others = bounces.impacts
    thrown = tuple(replace(one, speed_after_m_s=2.6, e=1.3, valid=False) for one in others)
    judged, (finding,) = judged_by_floor(replace(bounces, impacts=(first, *thrown)), track, G_M_S2)
    assert not judged.impacts[0].valid
    assert "the floor moves" in finding.text


def test_places_that_are_not_known_at_all_lie_in_any_plane() -> None:
    bounces, track = dropped(1e-3 * np.array([0.0, 0.2, 0.0, 0.0]), TOGETHER)
    assert off_one_plane(bounces, track)
    assert off_one_plane(bounces, replace(track, u_position_m=np.full_like(track.u_position_m, np.nan))) == []
