"""Oblique impacts: what is read of velocities and a normal, and what each is known to, against draws of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from radargui.model.radar import Floor
from radargui.model.result import Bounce, Bounces, Track, VelocitiesAtImpacts
from radargui.model.setup import Setup, read_setup
from radargui.model.uncertainty_budget import InputChange
from radargui.restitution.oblique import with_oblique
from radargui.system.resources import default_setup_path

AT_S = 0.5
BEFORE, AFTER = np.array([0.6, -0.3, -2.0]), np.array([0.4, -0.25, 1.5])
_TIME = np.linspace(0.0, 1.0, 1001)
_PLACE = np.stack([0.1 * _TIME, np.zeros_like(_TIME), 0.2 - _TIME])
TRACK = Track(_TIME, _PLACE, np.full_like(_PLACE, 1e-5), np.ones(_TIME.size, dtype=np.bool_), "exact")
READ = ("speed_before_m_s", "speed_after_m_s", "angle_deg", "e_t", "mu")


def setup_of(**floor: Any) -> Setup:
    return read_setup(default_setup_path()).model_copy(update={"floor": Floor(height_m=0.0, **floor)})


def one_impact(
    before: np.ndarray = BEFORE,
    after: np.ndarray = AFTER,
    covariance: np.ndarray | None = None,
    slope_variance: float = 0.0,
    changes: tuple[InputChange, ...] = (),
    setup: Setup | None = None,
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> Bounce:
    covariance = 1e-10 * np.eye(6) if covariance is None else covariance
    known = VelocitiesAtImpacts(np.array([AT_S]), before[None], after[None], covariance[None], slope_variance)
    into, out = -float(before @ normal), float(after @ normal)
    bounce = Bounce(AT_S, into, out, out / into, 1e-4, "made", True)
    bounces = Bounces((bounce,), None, normal, velocities=known)
    (read,) = with_oblique(bounces, changes, TRACK, setup or setup_of()).impacts
    return read


def test_it_reads_place_angle_and_what_the_floor_did_along_itself() -> None:
    read = one_impact()
    arrives, leaves = BEFORE[:2], AFTER[:2]
    assert (read.x_m, read.y_m, read.z_m) == pytest.approx((0.05, 0.0, -0.3))
    assert read.u_position_m == pytest.approx(1e-5)
    assert read.angle_deg == pytest.approx(np.degrees(np.arctan2(np.hypot(*arrives), 2.0)))
    assert read.vt_before_m_s == pytest.approx(np.hypot(*arrives))
    assert read.vt_after_m_s == pytest.approx(np.hypot(*leaves))
    assert read.e_t == pytest.approx(arrives @ leaves / (arrives @ arrives))
    assert read.mu == pytest.approx(np.hypot(*(leaves - arrives)) / 3.5)


@pytest.mark.slow
def test_uncertainties_are_those_of_draws() -> None:
    rng = np.random.default_rng(5)
    root = 0.004 * rng.normal(size=(6, 6))
    covariance, slope_sd = root @ root.T, 0.005
    read = one_impact(covariance=covariance, slope_variance=slope_sd**2)
    drawn = []
    for _ in range(2000):
        moved = np.concatenate([BEFORE, AFTER]) + root @ rng.normal(size=6)
        lean = np.array([*(slope_sd * rng.normal(size=2)), 1.0])
        x, y, z = (float(part) for part in lean / np.linalg.norm(lean))
        drawn.append(one_impact(moved[:3], moved[3:], normal=(x, y, z)))
    for name in READ:
        spread = np.std([getattr(one, name) for one in drawn])
        assert getattr(read, f"u_{name}") == pytest.approx(spread, rel=0.1), name


def test_a_third_of_a_degree_of_the_normal_is_half_a_per_cent_of_friction() -> None:
    read = one_impact(setup=setup_of(normal=(0.0, 0.0, 1.0), u_tilt_deg=0.3))
    assert read.u_mu == pytest.approx(np.radians(0.3), rel=0.1)
    assert one_impact().u_mu < 1e-4


def test_what_the_setup_leaves_open_is_in_it() -> None:
    time = np.linspace(0.0, 1.0, 2001)
    moved = np.zeros((3, time.size))
    moved[0] = 0.01 * time
    change = InputChange("receiver[1].tilt_deg", "calibration", time, moved, np.zeros(1), 0.0)
    read = one_impact(changes=(change,))
    # both velocities are off alike: the change at the impact is not
    assert read.u_angle_deg == pytest.approx(np.degrees(0.01 * 2.0 / (2.0**2 + 0.45) * 0.6 / np.sqrt(0.45)), rel=0.05)
    assert read.u_mu < 1e-4


def test_a_speed_along_the_floor_that_noise_alone_makes_is_none() -> None:
    noise = 0.02**2 * np.eye(6)
    read = one_impact(np.array([0.02, 0.0, -2.0]), np.array([0.0, 0.02, 1.5]), covariance=noise)
    assert read.vt_before_m_s == 0.0
    assert read.angle_deg == 0.0
    assert np.isnan([read.e_t, read.u_e_t]).all()
    assert read.u_angle_deg > 0.3


def test_where_no_velocities_are_known_only_the_place_is() -> None:
    bounces = Bounces((Bounce(AT_S, 2.0, 1.5, 0.75, 1e-3, "made", True),), None, (0.0, 0.0, 1.0))
    (read,) = with_oblique(bounces, (), TRACK, setup_of()).impacts
    assert (read.x_m, read.y_m, read.z_m) == pytest.approx((0.05, 0.0, -0.3))
    assert np.isnan([read.angle_deg, read.mu, read.e_t]).all()
