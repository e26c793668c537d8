"""A sphere over a floor as the estimate has it: against the generator's two bodies, and between the rounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.antenna import Antenna
from benchmarks.world.exchange import Exchange
from benchmarks.world.mirror import Conductor
from benchmarks.world.room import Room
from benchmarks.world.sphere import Sphere

from radargui.estimation.forward.parameters import Sizes, make_layout
from radargui.estimation.forward.signal_model import ModelInputs, shown, waves_at
from radargui.estimation.forward.sphere import PolarisedSphere
from radargui.model.scattering import mie_sphere, transmitted_direction, transverse_axes
from radargui.physics.mirrors import FLOOR, MirrorPlane
from radargui.physics.path_length import Antennas, range_factor

WAVENUMBER_RAD_M = 2.0 * np.pi * 10e9 / 299_792_458.0
RADIUS_M, REFLECTION, ANGLES_RAD = 0.006, 0.8 * np.exp(0.3j), (0.3, 0.8)
TRANSMITTER_M, RECEIVER_M, RELEASE_M = (
    np.array([0.0, 0.0, 0.7]),
    np.array([0.45, 0.1, 0.53]),
    np.array([0.0, 0.0, 0.12]),
)
ANTENNAS = Antennas(TRANSMITTER_M, RECEIVER_M[None])
PLANE, UNKNOWN = (
    MirrorPlane(np.array([0.0, 0.0, -0.1]), np.array([0.0, 0.0, 1.0]), FLOOR),
    np.array([0.01, -0.02, 0.002]),
)
AXES = np.array(
    [
        [transmitted_direction(0.0), transmitted_direction(90.0)],
        transverse_axes(RECEIVER_M / np.linalg.norm(RECEIVER_M)),
    ]
)
BODY = PolarisedSphere(
    mie_sphere(RADIUS_M, 2.0 * np.pi / WAVENUMBER_RAD_M), AXES[0], AXES[1:], np.array(ANGLES_RAD), np.ones(2)
)


def from_release(reflection: complex, antenna_m: np.ndarray) -> complex:
    """Return T or R of a floor as the estimate counts it: from the release, and of a field turned like a vector."""
    image_m = PLANE.image(antenna_m, UNKNOWN)
    way_m = np.linalg.norm(RELEASE_M - image_m) - np.linalg.norm(RELEASE_M - antenna_m)
    return complex(-reflection * np.exp(1j * WAVENUMBER_RAD_M * way_m))


T = from_release(REFLECTION, TRANSMITTER_M)


def places() -> np.ndarray:
    """From the release to 2 mm over the floor, shape (3, n)."""
    floor_m = PLANE.foot_m[2] + UNKNOWN[2]
    z = np.concatenate([RELEASE_M[2:], np.linspace(0.12, floor_m + RADIUS_M + 0.002, 50)])
    return np.stack([0.01 * (z < 0.1), 0.0 * z, z])


def test_all_waves_between_antennas_sphere_and_floor_are_those_of_the_generator() -> None:
    place = places()
    normal = PLANE.turned_normal(UNKNOWN)
    offset_m = float(normal @ (PLANE.foot_m + UNKNOWN[2] * PLANE.normal))
    turns = [np.array([np.cos(one), np.sin(one)]) for one in ANGLES_RAD]
    antennas = tuple(
        Antenna(one, -one / np.linalg.norm(one), turn @ axes, 0.0)
        for one, turn, axes in zip((TRANSMITTER_M, RECEIVER_M), turns, AXES, strict=True)
    )
    sphere = Sphere(RADIUS_M, WAVENUMBER_RAD_M)
    once = Room(antennas, sphere, (Conductor(normal, offset_m, REFLECTION * np.ones(2, complex)),))
    room = replace(once, exchange=Exchange(RADIUS_M, sphere.series(), REFLECTION, WAVENUMBER_RAD_M, 0.25))

    layout = make_layout(Sizes(0, 1, 1, 0, 0, 0, 1))
    theta = np.zeros(layout.size)
    theta[layout.planes], theta[layout.polarization] = UNKNOWN, ANGLES_RAD[0]
    theta[layout.transmitter_reflection] = T.real, T.imag
    theta[layout.exchange] = 1.0, 0.0
    own, back = layout.receivers[0], from_release(REFLECTION, RECEIVER_M)
    theta[own.polarization], theta[own.receiver_reflection] = ANGLES_RAD[1], (back.real, back.imag)
    none = np.zeros((place.shape[1], 0))
    fields = BODY.fields(place, ANTENNAS, RELEASE_M, (PLANE,), theta[layout.mirrors])
    strength = range_factor(place, ANTENNAS, RELEASE_M)
    inputs = ModelInputs(
        ANTENNAS, RELEASE_M, WAVENUMBER_RAD_M, (PLANE,), none, none, strength, np.zeros((2, *none.shape)), fields
    )
    nodes = np.broadcast_to(place[:, None, None], (3, 2, 2, place.shape[1]))
    ratio = shown(waves_at(np.ascontiguousarray(nodes), theta, layout, inputs, 0))[0] / room.received(0, place)
    np.testing.assert_allclose(ratio / ratio[0], 1.0, atol=1e-3)
    assert np.abs(room.received(0, place) / once.received(0, place) - 1.0).max() > 0.1


@pytest.mark.parametrize(
    "of", ["height", "shift", "real part of T", "imaginary part of T", "real part of R", "imaginary part of R"]
)
def test_the_exchange_follows_the_sphere_and_the_floor_between_rounds(of: str) -> None:
    place, mirrors = places(), np.array([*UNKNOWN, T.real, T.imag, 0.8, 0.1])
    moved_m, moved = place.copy(), mirrors.copy()
    if of == "height":
        moved_m[2] += 1e-4
    else:
        places_of = {"shift": 2, "real part of T": 3, "imaginary part of T": 4, "real part of R": 5}
        places_of["imaginary part of R"] = 6
        moved[places_of[of]] += 1e-4 if of == "shift" else 0.01

    def signal(fields_m: np.ndarray, made: np.ndarray, at_m: np.ndarray, at: np.ndarray) -> np.ndarray:
        fields = BODY.fields(fields_m, ANTENNAS, RELEASE_M, (PLANE,), made)
        factors = fields.moved(at, at_m).factors(0, *ANGLES_RAD)
        return factors.direct * factors.mirrored

    # at the same directions, which count as they were
    still, anew = signal(place, mirrors, place, mirrors), signal(moved_m, moved, moved_m, moved)
    followed = signal(place, mirrors, moved_m, moved)
    once = [BODY.basis(one, ANTENNAS, (PLANE,), two[None, :3]) for one, two in ((place, mirrors), (moved_m, moved))]
    turned = np.abs(once[1] - once[0]).max() / np.abs(once[0]).max()
    assert np.abs(anew - still).max() > 2e-3
    assert np.abs(followed - anew).max() < 0.1 * np.abs(anew - still).max() + 3.0 * turned


def test_a_plane_that_cuts_the_sphere_counts_as_touched_wherever_it_is() -> None:
    place, mirrors = places(), np.array([*UNKNOWN, T.real, T.imag, 1.0, 0.0])
    mirrors[2] += 0.004
    higher = mirrors.copy()
    higher[2] += 1e-4

    def signal(made: np.ndarray, at: np.ndarray) -> np.ndarray:
        factors = BODY.fields(place, ANTENNAS, RELEASE_M, (PLANE,), made).moved(at, place).factors(0, *ANGLES_RAD)
        return factors.direct * factors.mirrored

    assert np.abs(signal(higher, higher) - signal(mirrors, mirrors)).max() < 5e-4
    assert np.abs(signal(mirrors, higher) - signal(mirrors, mirrors)).max() < 5e-4


def test_without_a_floor_that_reflects_there_is_no_exchange() -> None:
    place = places()
    fields = BODY.fields(place, ANTENNAS, RELEASE_M, (PLANE,), np.array([*UNKNOWN, 0.0, 0.0, 1.0, 0.0]))
    np.testing.assert_array_equal(fields.basis, BODY.basis(place, ANTENNAS, (PLANE,), UNKNOWN[None]))
