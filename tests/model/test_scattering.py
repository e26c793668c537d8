"""Scattering by a conducting sphere: tabulated values, the optical theorem, the Rayleigh limit, mirrored antennas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.scattering import (
    mie_sphere,
    received_direction,
    scattered_field,
    scattering_coefficients,
    strongest_polarization_deg,
    transmitted_direction,
    transverse_axes,
)
from radargui.physics.path_length import mirror

WAVELENGTH_M = 0.0299792458
TRANSMITTER_M = np.array([0.0, 0.0, 0.7])
DIRECTION = np.array([np.sin(0.6981317) * np.cos(3.6826447), np.sin(0.6981317) * np.sin(3.6826447), np.cos(0.6981317)])


def amplitudes(size: float, cosine: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """S1, of the field across the scattering plane, and S2, of that in it; size = 2 pi radius / wavelength."""
    u, v = mie_sphere(size / (2.0 * np.pi), 1.0).parts(cosine)
    return np.asarray(u + cosine * v), np.asarray(v + cosine * u)


@pytest.mark.parametrize(
    ("size", "angle_deg", "across", "in_plane"),
    [
        (0.52, 0, 0.01718 - 0.08830j, 0.01718 - 0.08830j),
        (0.52, 40, 0.01660 - 0.10342j, 0.01373 - 0.05160j),
        (0.52, 140, 0.01283 - 0.19161j, -0.00882 + 0.17186j),
        (1.05, 40, 0.57179 - 0.51013j, 0.47229 - 0.16892j),
        (1.05, 140, 0.43605 - 0.89180j, -0.30120 + 0.83147j),
        (1.68, 0, 1.49874 - 0.45164j, 1.49874 - 0.45164j),
        (1.68, 140, 0.04741 - 0.67578j, 0.05323 + 0.87969j),
    ],
)
def test_the_amplitudes_are_the_tabulated_ones(
    size: float, angle_deg: float, across: complex, in_plane: complex
) -> None:
    found = amplitudes(size, np.array(np.cos(np.radians(angle_deg))))
    assert np.allclose(found, (across, in_plane), rtol=0, atol=1.1e-5)


@given(st.floats(0.05, 6.0))
def test_a_perfect_conductor_takes_out_of_the_beam_what_it_scatters(size: float) -> None:
    electric, magnetic = scattering_coefficients(size)
    forward = amplitudes(size, np.array(1.0))[0].real
    weight = 2.0 * np.arange(1, electric.size + 1) + 1.0
    # Bohren & Huffman, eq. 4.62, against the optical theorem
    extinction = 2.0 / size**2 * float((weight @ (electric + magnetic)).real)
    assert extinction == pytest.approx(4.0 / size**2 * forward, rel=1e-9)
    scattered = 2.0 / size**2 * float(weight @ (np.abs(electric) ** 2 + np.abs(magnetic) ** 2))
    assert extinction == pytest.approx(scattered, rel=1e-9)


@pytest.mark.parametrize(("size", "index", "efficiency"), [(5.2128, 1.55, 3.10543), (10.0, 1.5, 2.8820)])
def test_a_plastic_sphere_takes_out_of_the_beam_what_is_tabulated(size: float, index: float, efficiency: float) -> None:
    # Bohren & Huffman, appendix A, and Wiscombe's test cases (NCAR TN-140, 1979)
    electric, magnetic = scattering_coefficients(size, index)
    weight = 2.0 * np.arange(1, electric.size + 1) + 1.0
    assert 2.0 / size**2 * float((weight @ (electric + magnetic)).real) == pytest.approx(efficiency, abs=2e-4)
    scattered = 2.0 / size**2 * float(weight @ (np.abs(electric) ** 2 + np.abs(magnetic) ** 2))
    assert scattered == pytest.approx(efficiency, abs=2e-4)


def test_an_endless_index_makes_a_conductor() -> None:
    dense, metal = scattering_coefficients(1.2, 1e3), scattering_coefficients(1.2)
    assert all(np.allclose(one, other, rtol=0, atol=2e-2) for one, other in zip(dense, metal, strict=True))


def test_a_tiny_sphere_is_an_electric_and_half_a_magnetic_dipole() -> None:
    size, cosine = 0.01, np.linspace(-1.0, 1.0, 9)
    across, in_plane = amplitudes(size, cosine)
    # Jackson, Classical Electrodynamics, section 10.1 C; the electric dipole's amplitude is -i x^3
    assert across == pytest.approx(-1j * size**3 * (1.0 - cosine / 2.0), rel=1e-3)
    assert in_plane == pytest.approx(-1j * size**3 * (cosine - 0.5), rel=1e-3, abs=1e-9)


def signal(
    position: FloatArray, transmitter: FloatArray, transmitted: FloatArray, receiver: FloatArray, received: FloatArray
) -> ComplexArray:
    sphere = mie_sphere(0.005, WAVELENGTH_M)
    return np.asarray(received @ scattered_field(sphere, position, transmitter, transmitted, receiver))


def test_the_worked_example_with_a_floor_is_met() -> None:
    transmitted, receiver = transmitted_direction(0.0), 0.7 * DIRECTION
    horizontal, vertical = transverse_axes(DIRECTION)
    centre = scattered_field(mie_sphere(0.005, WAVELENGTH_M), np.zeros((3, 1)), TRANSMITTER_M, transmitted, receiver)
    received = received_direction(strongest_polarization_deg(centre[:, 0], horizontal, vertical), horizontal, vertical)
    assert received == pytest.approx([0.83232, -0.15138, 0.53322], abs=1e-5)
    position, release = np.array([[0.01], [-0.005], [0.05]]), np.array([[0.0], [0.0], [0.125]])
    up = np.array([0.0, 0.0, 1.0])
    low_tx, low_rx = mirror(TRANSMITTER_M, up, -0.145), mirror(receiver, up, -0.145)
    low_sent, low_got = mirror(transmitted, up, 0.0), mirror(received, up, 0.0)
    direct = signal(position, TRANSMITTER_M, transmitted, receiver, received)
    at_release = signal(release, TRANSMITTER_M, transmitted, receiver, received)
    assert direct / at_release == pytest.approx(1.03274 + 0.01324j, abs=2e-5)
    assert signal(position, low_tx, low_sent, receiver, received) / direct == pytest.approx(0.4374 + 0.4004j, abs=1e-4)
    assert signal(position, TRANSMITTER_M, transmitted, low_rx, low_got) / direct == pytest.approx(
        0.5513 + 0.4213j, abs=1e-4
    )
    assert signal(position, low_tx, low_sent, low_rx, low_got) / direct == pytest.approx(1.0514 + 0.0334j, abs=1e-4)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_straight_on_and_straight_back_are_the_limits_of_small_angles(side: float) -> None:
    # Without a limit here the tracer on the axis between two antennas would have no signal at all
    sphere, sent = mie_sphere(0.005, WAVELENGTH_M), transmitted_direction(20.0)
    receiver = np.array([0.0, 0.0, 0.5 * side])
    on_axis = scattered_field(sphere, np.zeros((3, 1)), TRANSMITTER_M, sent, receiver)
    beside = scattered_field(sphere, np.full((3, 1), 1e-5), TRANSMITTER_M, sent, receiver)
    assert np.isfinite(on_axis).all()
    assert on_axis == pytest.approx(beside, rel=1e-3, abs=1e-4)


def test_the_strongest_polarisation_is_stronger_than_any_other() -> None:
    horizontal, vertical = transverse_axes(DIRECTION)
    field = scattered_field(
        mie_sphere(0.008, WAVELENGTH_M),
        np.zeros((3, 1)),
        TRANSMITTER_M,
        transmitted_direction(77.0),
        0.7 * DIRECTION,
    )[:, 0]
    best = strongest_polarization_deg(field, horizontal, vertical)
    strength = [abs(received_direction(angle, horizontal, vertical) @ field) for angle in np.arange(0.0, 180.0, 0.5)]
    assert abs(received_direction(best, horizontal, vertical) @ field) >= max(strength)
    assert abs(np.arange(0.0, 180.0, 0.5)[int(np.argmax(strength))] - best) <= 0.5


def test_an_antenna_straight_above_has_the_axes_of_its_azimuth() -> None:
    horizontal, vertical = transverse_axes(np.array([0.0, 0.0, 1.0]), 90.0)
    assert horizontal == pytest.approx([-1.0, 0.0, 0.0])
    assert vertical == pytest.approx([0.0, -1.0, 0.0])
