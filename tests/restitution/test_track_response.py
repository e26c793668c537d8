"""The first-order answer of e and g to a shift of the track, against bounces found anew in the shifted track."""

from dataclasses import replace

import numpy as np
import pytest
from support.drops import Drop

from radargui.model.assumed import CONTACT_S
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2
from radargui.model.resources import default_setup_path
from radargui.model.result import Bounce, Bounces, Segment, Track
from radargui.model.setup import read_setup
from radargui.restitution.bounces import find_bounces
from radargui.restitution.track_response import respond, tilt_and_clock

UP = (0.0, 0.0, 1.0)
DROP = Drop(height_m=0.2, e=0.8, rate_hz=2000.0)


def drifting_track() -> tuple[Track, Segment]:
    time = DROP.time_s
    position = np.stack([0.02 * time, -0.01 * time, DROP.height(time)])
    segment = Segment(
        round(DROP.rest_s * DROP.rate_hz),
        round((DROP.impact_s[-1] + 0.02) * DROP.rate_hz),
        0,
        round((DROP.rest_s - 0.02) * DROP.rate_hz),
    )
    known = np.ones(time.size, dtype=bool)
    return Track(time, position, np.full_like(position, 1e-5), known, "exact"), segment


def shifts(track: Track) -> np.ndarray:
    """Return what a wrong antenna does: fields of position, a quadratic, a stretch and a leaning."""
    x, _, z = track.position_m
    nothing = np.zeros_like(z)
    return np.stack(
        [
            np.stack([nothing, nothing, 1e-3 * z]),
            np.stack([nothing, nothing, 5e-3 * z**2]),
            np.stack([2e-3 * z, -1e-3 * z, 0.02 * x * z]),
        ]
    )


@pytest.mark.parametrize("normal", [UP, None])
def test_it_is_what_the_bounces_of_the_shifted_track_differ_by(normal: tuple[float, float, float] | None) -> None:
    track, segment = drifting_track()
    before, moved = find_bounces(track, segment, normal, DROP.rate_hz, G_M_S2), shifts(track)
    e, g = respond(track, segment, before, moved, normal is not None, G_M_S2)
    for own, de, dg in zip(moved, e, g, strict=True):
        shifted = replace(track, position_m=track.position_m + own)
        after = find_bounces(shifted, segment, normal, DROP.rate_hz, G_M_S2)
        assert before.free_fall is not None
        assert after.free_fall is not None
        change = [b.e - a.e for a, b in zip(before.impacts, after.impacts, strict=True)]
        assert de == pytest.approx(change, rel=0.02, abs=5e-8, nan_ok=True)
        assert dg == pytest.approx(after.free_fall.g_m_s2 - before.free_fall.g_m_s2, rel=0.02, abs=1e-5)


def test_a_stretched_height_changes_g_alike_and_e_not() -> None:
    track, segment = drifting_track()
    bounces = find_bounces(track, segment, UP, DROP.rate_hz, G_M_S2)
    assert bounces.free_fall is not None
    e, g = respond(track, segment, bounces, shifts(track)[:1], given_normal=True, gravity_m_s2=G_M_S2)
    assert np.nanmax(np.abs(e)) < 5e-8
    assert g[0] == pytest.approx(1e-3 * bounces.free_fall.g_m_s2, rel=1e-6)


def test_without_impacts_there_is_nothing_to_change() -> None:
    track, segment = drifting_track()
    e, g = respond(track, segment, Bounces(), shifts(track), given_normal=True, gravity_m_s2=G_M_S2)
    assert e.shape == (3, 0)
    assert np.isnan(g).all()


def test_an_impact_that_lasts_as_long_as_hard_floors_do_is_within_the_uncertainty_of_e() -> None:
    before, e, lasts_s = 1.1, 0.7, CONTACT_S
    after, g = e * before, 9.81
    # the parabolas before and after the contact, which begins at 0 and ends at `lasts_s` at the same height, meet at t
    t = np.linspace(0.0, lasts_s, 100001)
    down, up = -before * t - g / 2.0 * t**2, after * (t - lasts_s) - g / 2.0 * (t - lasts_s) ** 2
    meet = t[np.argmin(np.abs(down - up))]
    seen = (after + g * (lasts_s - meet)) / (before + g * meet)
    bounces = Bounces((Bounce(0.5, before, after, e, 1e-5, "flights", True),), None, (0.0, 0.0, 1.0))
    time = np.linspace(0.0, 1.0, 5)
    side = np.array([[0.0, 0.0, before]])
    (change,) = tilt_and_clock(time, lambda: (-side, e * side), bounces, read_setup(default_setup_path()))[-1:]
    assert seen - e > 1e-4
    assert change.e == pytest.approx([seen - e], rel=0.01)
    assert not change.moved_m.any()
    # on steel after a fall of 25 cm it is a ten-thousandth, and nothing where nothing was hit
    assert tilt_and_clock(time, lambda: (-side, e * side), Bounces(), read_setup(default_setup_path())) == []
