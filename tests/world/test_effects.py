"""What else laboratories have, against closed forms, brute force and published values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.container import Container
from benchmarks.world.drawn_drop import OPTIONS, WAVENUMBER_RAD_M
from benchmarks.world.draws import Draws
from benchmarks.world.effects import EFFECT_OPTIONS, FLOORS, STEEL, draw_effects
from benchmarks.world.horn import Horn
from benchmarks.world.kinds import draw
from benchmarks.world.mirror import Plate, Slab
from benchmarks.world.receiver_chain import Mixer
from benchmarks.world.sphere import coefficients, dielectric_coefficients

UP = np.array([0.0, 0.0, 1.0])


def test_a_dielectric_sphere_extinguishes_as_published_and_a_dense_one_is_nearly_a_conductor() -> None:
    # Bohren & Huffman 1983, appendix A: m = 1.55, radius 0.525 um at 0.6328 um in vacuum
    size = 2.0 * np.pi * 0.525 / 0.6328
    a, b = dielectric_coefficients(size, 1.55)
    order = np.arange(1, a.size + 1)
    assert 2.0 / size**2 * ((2 * order + 1) * (a + b).real).sum() == pytest.approx(3.10543, abs=5e-6)
    for dense, conducting in zip(dielectric_coefficients(1.05, 300.0 + 300.0j), coefficients(1.05), strict=True):
        assert np.abs(dense - conducting).max() < 0.01


# straight down, and at 40 degrees across and in the plane of incidence
REFLECTED = {0.12: (0.12, 0.04, 0.02), 0.29: (0.29, 0.68, 0.45), 0.66: (0.66, 0.78, 0.55), 0.72: (0.72, 0.73, 0.50)}


@pytest.mark.parametrize("share", FLOORS)
def test_floors_of_plates_reflect_what_such_plates_do(share: float) -> None:
    material = FLOORS[share][1]
    slab = Slab(
        UP, 0.0, material.index**2, thickness_m=material.thickness_m, wavenumber_rad_m=WAVENUMBER_RAD_M
    )  # fmt: skip
    r_s, r_p = slab.ratios(np.array([1.0, np.cos(np.radians(40.0))]))
    assert abs(slab.straight_down()) == pytest.approx(REFLECTED[share][0], abs=0.02)
    np.testing.assert_allclose([abs(r_s[1]), abs(r_p[1])], REFLECTED[share][1:], atol=0.02)
    # half a wave of it is invisible
    whole = np.pi / (WAVENUMBER_RAD_M * 1.6)
    r_s, _ = replace(slab, permittivity=1.6**2 + 0j, thickness_m=whole).ratios(np.ones(1))
    assert abs(r_s[0]) < 1e-9


@pytest.mark.parametrize(("aside_m", "height_m"), [(0.0, 0.2), (0.03, 0.2), (0.0, 0.05), (0.0, 0.01), (0.01, 0.005)])
def test_a_plate_sends_back_what_kirchhoffs_integral_over_it_does(aside_m: float, height_m: float) -> None:
    source, place, half_m = np.array([0.05, 0.0, 0.7]), np.array([aside_m, 0.01, height_m]), (0.05, 0.04)
    x, y = np.meshgrid(np.linspace(-0.05, 0.05, 801), np.linspace(-0.04, 0.04, 801), indexing="ij")
    wide = np.stack([x, y, np.zeros_like(x)])
    way = sum(np.linalg.norm(wide - one[:, None, None], axis=0) for one in (source, place))
    image = source * [1.0, 1.0, -1.0]
    direct = np.linalg.norm(place - image)
    cells = (x[1, 0] - x[0, 0]) * (y[0, 1] - y[0, 0])
    there, back = (np.linalg.norm(wide - one[:, None, None], axis=0) for one in (source, place))
    # an endless plane sends exp(i K r) / r; the mean of both obliquities, as a field aslant to the edges has it
    leaves = ((1.0 / one - 1j * WAVENUMBER_RAD_M) * up / one for one, up in ((there, source[2]), (back, place[2])))
    summed = (0.5 * sum(leaves) * np.exp(1j * WAVENUMBER_RAD_M * way) / (there * back)).sum() * cells / (2.0 * np.pi)
    field = np.array([[1.0], [1.0], [0.0]], complex)
    told = Plate(np.zeros(3), np.eye(3)[:2], half_m).seen(source, place[:, None], UP, field, WAVENUMBER_RAD_M)[0]
    assert abs(told - summed / (np.exp(1j * WAVENUMBER_RAD_M * direct) / direct)) < (0.05 if height_m > 0.1 else 0.1)


def test_a_wide_plate_is_an_endless_floor() -> None:
    place = np.array([[0.0], [0.02], [0.2]])
    field = np.array([[1.0], [0.0], [0.0]], complex)
    told = Plate(np.zeros(3), np.eye(3)[:2], (20.0, 20.0)).seen(0.7 * UP, place, UP, field, WAVENUMBER_RAD_M)
    assert abs(told[0] - 1.0) < 0.01


def test_foam_delays_the_ray_below_its_rim_and_none_above() -> None:
    box = Container((0.3, 0.3), 0.03, 1.015, 0.0)
    antenna = np.array([0.6, 0.0, 0.0])
    deep, high = (box.delay(antenna, np.array([[0.0], [0.0], [z]]), WAVENUMBER_RAD_M)[0] for z in (-1.0, 1.0))
    cosine = 0.6 / np.hypot(0.6, 1.0)
    assert np.angle(deep) / WAVENUMBER_RAD_M == pytest.approx(0.015 * 0.03 / cosine, rel=0.05)
    assert abs(deep) == pytest.approx(1.0, abs=0.03)
    assert high == pytest.approx(1.0, abs=0.03)


def test_a_horn_seems_to_send_from_behind_its_aperture_and_one_point_leaves_a_tenth_of_a_millimetre() -> None:
    horn = Horn(0.045, 0.16, WAVENUMBER_RAD_M, 0.7)
    assert 0.01 < horn.behind_m < 0.15
    assert horn.factor(np.ones(1), np.array([0.7]))[0] == pytest.approx(1.0)
    range_m, angle = np.meshgrid(np.linspace(0.5, 0.9, 9), np.radians(np.linspace(0.0, 20.0, 9)))
    late = np.angle(horn.factor(np.cos(angle.ravel()), range_m.ravel())) / WAVENUMBER_RAD_M
    assert 2e-5 < late.std() < 2e-4
    # on the axis Huygens' integral over rings is a plain one
    ring = (np.arange(4000) + 0.5) / 4000 * horn.radius_m
    source = np.cos(0.5 * np.pi * ring / horn.radius_m) * ring
    source = source * np.exp(1j * WAVENUMBER_RAD_M * (np.hypot(horn.flare_m, ring) - horn.flare_m))

    def wave(range_m: float) -> complex:
        away = np.hypot(range_m - horn.behind_m, ring)
        turn = np.exp(1j * WAVENUMBER_RAD_M * (away - range_m)) / away
        return complex((source * turn).sum() * range_m)

    assert horn.factor(np.ones(1), np.array([0.4]))[0] == pytest.approx(wave(0.4) / wave(0.7), rel=1e-3)


def test_harmonics_of_a_mixer_turn_at_three_times_the_phase_either_way() -> None:
    turns = np.arange(360) * 2.0 * np.pi / 360.0
    mixer = Mixer(1.0, 1.0, 0.0, (0.0, 0.0), (0.01j, 0.002))
    signal = mixer.volts(0.5 * np.exp(1j * turns), 0) + 1j * mixer.volts(0.5 * np.exp(1j * turns), 1)
    lines = np.fft.fft(signal) / 360.0
    assert lines[1] == pytest.approx(0.5)
    assert lines[-3] == pytest.approx(0.005j)
    assert lines[3] == pytest.approx(0.001)


def test_setups_are_off_by_what_they_state() -> None:
    scenes = [draw("modelled", 77, number, {"exact": False, "told": True}) for number in range(60)]
    pulls: dict[str, list[float]] = {}
    for one in scenes:
        stated, true = one.setup, one.facts["true"]
        for table, truth in zip(stated["receiver"], true["receiver"], strict=True):
            for name in ("tilt_deg", "azimuth_deg", "distance_m"):
                off = (table[name] - truth[name] + 180.0) % 360.0 - 180.0
                pulls.setdefault(name, []).append(off / table[f"u_{name}"])
        for name in ("x_m", "y_m"):
            pulls.setdefault(name, []).append(true["transmitter"][name] / stated["transmitter"][f"u_{name}"])
        place = np.subtract(stated["tracer"]["release_position_m"], true["tracer"]["release_position_m"])
        pulls.setdefault("release", []).extend(place / stated["tracer"]["u_release_m"])
        scatter = np.subtract(one.facts["release_m"], true["tracer"]["release_position_m"])
        pulls.setdefault("scatter", []).extend(scatter / stated["tracer"]["u_release_scatter_m"])
    # the mean square of n pulls is 1 +- sqrt(2 / n): five of these
    for name, found in pulls.items():
        assert np.mean(np.square(found)) == pytest.approx(1.0, abs=5.0 * np.sqrt(2.0 / len(found))), name


def test_effects_are_as_frequent_as_was_asked_for() -> None:
    count = 400
    drawn = [draw_effects(Draws((78, number), {}, (*OPTIONS, *EFFECT_OPTIONS))) for number in range(count)]
    shares = {"horns": 0.25, "harmonics": 0.25, "container": 0.12, "holder": 0.12, "sphere": 0.12, "plate": 0.2}
    # four standard deviations of a binomial number
    for cause, share in shares.items():
        found = sum(cause in one.causes for one in drawn)
        assert found == pytest.approx(count * share, abs=4.0 * np.sqrt(count * share * (1.0 - share))), cause
    floors = [one.floor for one in drawn]
    for share in (*FLOORS, STEEL):
        assert floors.count(share) == pytest.approx(count / 6, abs=4.0 * np.sqrt(count * 5.0) / 6.0)


def test_options_are_drawn_by_name() -> None:
    value = Draws((1, 2), {"e": 0.5}, OPTIONS)
    assert value.between("e", 0.2, 0.95) == 0.5
    assert value.between("height_m", 0.1, 0.2) == Draws((1, 2), {}, OPTIONS).between("height_m", 0.1, 0.2)
