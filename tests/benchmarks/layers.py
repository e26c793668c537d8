"""Exchange of sphere and floor over plates: the model's, without and with the plate, against a sphere over layers.

The other side is the generator's (`world/layers.py`): outgoing vector waves as plane waves of every direction, each
with its own R_TE and R_TM. Antennas are far enough for plane waves at the sphere, and what goes over the plate once has
each angle's R on both sides: what differs is what goes to and fro. Fails where the model, told of the plate, is off by
more than 0.01 of the direct wave from 2 mm on, or where the conductor is not that of the check values.
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np
from benchmarks.world.exchange import Exchange, incident, radiated, sum_of
from numpy.typing import NDArray

from radargui.model.scattering import mie_sphere, received_direction, scattered_signals, transmitted_direction
from radargui.model.setup import Setup, validate_setup
from radargui.physics.path_length import place_antennas
from radargui.physics.plate import Plate, exchanged_signals

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

GLASS, ACRYLIC, GRANITE = 2.6 + 0.005j, 1.6 + 0.01j, 2.445 + 0.01j
PLATES = {
    "steel": Plate(None),
    "glass 4 mm": Plate(GLASS, 0.004),
    "glass 6 mm": Plate(GLASS, 0.006),
    "glass 10 mm": Plate(GLASS, 0.010),
    "glass 20 mm": Plate(GLASS, 0.020),
    "granite 30 mm": Plate(GRANITE, 0.030),
    "acrylic 4 mm": Plate(ACRYLIC, 0.004),
    "acrylic 10 mm": Plate(ACRYLIC, 0.010),
    "acrylic 20 mm": Plate(ACRYLIC, 0.020),
    "acrylic 4 mm on metal": Plate(ACRYLIC, 0.004, None),
    "acrylic 10 mm on metal": Plate(ACRYLIC, 0.010, None),
    "glass 10 mm on metal": Plate(GLASS, 0.010, None),
}
DIAMETERS_MM = (5.0, 10.0, 16.0)
GAPS_MM = np.concatenate([np.arange(0.0, 2.0, 0.25), np.arange(2.0, 10.0, 0.5), np.arange(10.0, 50.5, 1.0)])
CONTACT_MM, NEAR_MM = 2.0, 10.0
"""Gaps where contact ends, and to where it is near the floor."""
TILT_DEG, DISTANCE_M, FLOOR_M, BESIDE_M = 40.0, 0.7, -0.15, (0.01, -0.005)
"""Of receivers; of all antennas; height of the surface; place of the drop beside the axis."""
CHECKED_MM = ((5.0, 0.068, 1.046), (10.0, 1.045, 0.871), (16.0, 1.777, 0.937))
"""Diameter, and path (mm) and modulus of all waves over those of image theory 5 mm above a conductor, tilt 0.7 rad."""
MOST = 0.01
"""Of the direct wave."""


class Difference(NamedTuple):
    """Exchange over the direct wave, shape (n_receivers, n): all of it, and what the model has more.

    Attributes
    ----------
    layered
        All of it.
    one_r, best
        Model less that: with R straight down for every angle, and that taken `strength` times, which fits best.
    each_r
        Model that knows the plate, less `layered`.
    strength
        Of `best`.
    """

    layered: Complex
    one_r: Complex
    best: Complex
    each_r: Complex
    strength: float


class Waves(NamedTuple):
    """Plane waves that meet the sphere, or answers to what leaves it: directly and over the plate.

    Attributes
    ----------
    direction
        Unit vectors along which waves go, shape (2, 3, n).
    field
        With phase and distance, shape (2, 3, n).
    """

    direction: Array
    field: Complex


def waves_to(antenna_m: Array, polarised: Array, place: Array, plate: Plate, wavenumber: float) -> Waves:
    """Return the waves from an antenna to places (3, n), each with its own angle on the plate."""
    mirror = np.array([1.0, 1.0, -1.0])
    image_m = antenna_m * mirror + [0.0, 0.0, 2.0 * FLOOR_M]
    ways = np.array([place - antenna_m[:, None], place - image_m[:, None]])
    length = np.linalg.norm(ways, axis=1)
    direction = ways / length[:, None]
    across = np.cross(direction[1], [[0.0], [0.0], [1.0]], axis=0)
    across /= np.linalg.norm(across, axis=0)
    upright = np.cross(across, direction[1], axis=0)
    turned = (polarised * mirror)[:, None]
    r_te, r_tm = plate.coefficients(np.abs(direction[1, 2]), wavenumber)
    over = -r_te * (across * turned).sum(axis=0) * across - r_tm * (upright * turned).sum(axis=0) * upright
    fields = np.array([np.broadcast_to(polarised[:, None], over.shape), over])
    return Waves(direction, fields * (np.exp(1j * wavenumber * length) / length)[:, None])


def once(radius_m: float, wavelength_m: float, sent: Waves, got: Waves) -> tuple[Complex, Complex]:
    """Return what is scattered once, by all ways and directly, shape (n,) each."""
    sphere, axes = mie_sphere(radius_m, wavelength_m), np.eye(3)
    pairs = scattered_signals(sphere, sent.direction[:, None], axes, -got.direction[None], axes)
    parts = np.einsum("asn,bgn,absgn->abn", sent.field, got.field, pairs)
    return parts.sum(axis=(0, 1)), parts[0, 0]


def modelled(
    radius_m: float,
    wavelength_m: float,
    height_m: Array,
    reflection: complex,
    sent: Waves,
    got: Waves,
    plate: Plate | None,
) -> Complex:
    """Return what the model has for the exchange, shape (n,)."""
    axes = np.array([np.eye(3), np.eye(3)])
    up = np.array([0.0, 0.0, 1.0])
    found = exchanged_signals(
        mie_sphere(radius_m, wavelength_m), height_m, reflection, up, sent.direction, axes, -got.direction, axes, plate
    )
    return np.einsum("asn,bgn,absgn->n", sent.field, got.field, found.signal)


def exchanged(
    radius_m: float, wavelength_m: float, gap_m: Array, sent: Waves, got: list[Waves], plate: Plate
) -> Complex:
    """Return what the generator has for the exchange, shape (n_receivers, n)."""
    sphere, k = mie_sphere(radius_m, wavelength_m), 2.0 * np.pi / wavelength_m
    layers = None if plate.index is None else lambda cosine: plate.coefficients(cosine, k)
    exchange = Exchange(
        radius_m, (sphere.electric, sphere.magnetic), plate.straight_down(k), k, float(gap_m.max()), layers=layers
    )
    arriving = sum_of(incident(*one) for one in zip(*sent, strict=True))
    leaving = [sum_of(radiated(-way, field) for way, field in zip(*one, strict=True)) for one in got]
    return exchange.received(gap_m, arriving, leaving)


def radar(tilt_deg: float, azimuths_deg: tuple[float, ...]) -> Setup:
    """Return receivers polarised for the strongest signal from the centre."""
    receivers = [{"tilt_deg": tilt_deg, "azimuth_deg": one, "distance_m": DISTANCE_M} for one in azimuths_deg]
    transmitter = {"distance_m": DISTANCE_M, "polarization_deg": 0.0}
    return validate_setup(
        {"schema": 1, "radar": {"frequency_hz": 10e9}, "transmitter": transmitter, "receiver": receivers}
    )


def all_waves(
    setup: Setup, plate: Plate, radius_m: float, gap_m: Array, beside_m: tuple[float, float]
) -> tuple[Waves, list[Waves]]:
    """Return the waves from the transmitter, and those of the receivers, at gaps (n,)."""
    k = 2.0 * np.pi / setup.radar.wavelength_m
    place = np.array([*np.outer(beside_m, np.ones(gap_m.size)), FLOOR_M + radius_m + gap_m])
    antennas = place_antennas(setup)
    sent = waves_to(antennas.transmitter_m, transmitted_direction(0.0), place, plate, k)
    answers = [received_direction(one.angle_deg, one.horizontal, one.vertical) for one in setup.received_fields()]
    got = [waves_to(*one, place, plate, k) for one in zip(antennas.receivers_m, answers, strict=True)]
    return sent, got


def difference(plate: Plate, diameter_m: float, setup: Setup, gap_m: Array) -> Difference:
    """Return exchange and differences at gaps (n,) under the sphere."""
    wavelength_m, radius_m = setup.radar.wavelength_m, 0.5 * diameter_m
    reflection = plate.straight_down(2.0 * np.pi / wavelength_m)
    sent, got = all_waves(setup, plate, radius_m, gap_m, BESIDE_M)
    direct = np.array([once(radius_m, wavelength_m, sent, one)[1] for one in got])
    layered = exchanged(radius_m, wavelength_m, gap_m, sent, got, plate) / direct
    one_r, each_r = (
        np.array([modelled(radius_m, wavelength_m, radius_m + gap_m, reflection, sent, one, known) for one in got])
        / direct
        for known in (None, plate)
    )
    strength = float((layered * one_r.conj()).real.sum() / (np.abs(one_r) ** 2).sum())
    return Difference(layered, one_r - layered, strength * one_r - layered, each_r - layered, strength)


def checked() -> float:
    """Return by how much the conductor's factor misses the check values at most: of 0.1 mm, and of 0.02."""
    setup, plate, worst = radar(float(np.degrees(0.7)), (0.0,)), PLATES["steel"], 0.0
    wavelength_m, gap_m = setup.radar.wavelength_m, np.array([0.005])
    for diameter_mm, path_mm, modulus in CHECKED_MM:
        radius_m = 0.5e-3 * diameter_mm
        sent, got = all_waves(setup, plate, radius_m, gap_m, (1e-7, 0.0))
        every, _ = once(radius_m, wavelength_m, sent, got[0])
        factor = (1.0 + exchanged(radius_m, wavelength_m, gap_m, sent, got, plate)[0] / every)[0]
        off_mm = 1e3 * np.angle(factor) * wavelength_m / (2.0 * np.pi) - path_mm
        worst = max(worst, abs(float(off_mm)) / 0.1, abs(abs(factor) - modulus) / 0.02)
    return worst


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plate", nargs="+", choices=PLATES, default=list(PLATES))
    parser.add_argument("--diameter-mm", nargs="+", type=float, default=DIAMETERS_MM)
    asked = parser.parse_args()
    setup, failed = radar(TILT_DEG, (90.0, 210.0, 330.0)), not checked() <= 1.0
    um = 1e6 * setup.radar.wavelength_m / (2.0 * np.pi) / (1.0 + np.cos(np.radians(TILT_DEG)))
    bands = (GAPS_MM < CONTACT_MM, (GAPS_MM >= CONTACT_MM) & (GAPS_MM < NEAR_MM), GAPS_MM >= NEAR_MM)
    print(f"conductor against the check values: {'missed' if failed else 'met'}")
    print(
        f"rms over receivers and gaps of 0 - {CONTACT_MM:g} | {CONTACT_MM:g} - {NEAR_MM:g} | {NEAR_MM:g} - "
        f"{GAPS_MM[-1]:g} mm; model less layers: amplitude (dB) and phase (rad) against the direct wave, and that as "
        f"height (um)"
    )
    print(
        f"{'plate':24}{'mm':>3}  |R|  {'exchange':24}{'one R: dB':20}{'rad':24}{'um':18}{'s':>5} {'rad':24}each R: all"
    )
    for name in asked.plate:
        plate = PLATES[name]
        size = abs(plate.straight_down(2.0 * np.pi / setup.radar.wavelength_m))
        for diameter_mm in asked.diameter_mm:
            off = difference(plate, 1e-3 * diameter_mm, setup, 1e-3 * GAPS_MM)
            failed |= not np.abs(off.each_r[:, ~bands[0]]).max() <= MOST
            columns = [
                _rms(np.abs(off.layered), bands),
                _rms(20.0 * np.log10(np.abs(1.0 + off.one_r)), bands),
                _rms(off.one_r.imag, bands),
                um * _rms(off.one_r.imag, bands),
                _rms(off.best.imag, bands),
                _rms(np.abs(off.each_r), bands),
            ]
            digits = (4, 2, 4, 0, 4, 4)
            texts = [" ".join(f"{one:.{n}f}" for one in column) for column, n in zip(columns, digits, strict=True)]
            print(
                f"{name:24}{diameter_mm:3.0f} {size:.2f}  {texts[0]:24}{texts[1]:20}{texts[2]:24}{texts[3]:18}"
                f"{off.strength:5.2f} {texts[4]:24}{texts[5]}",
                flush=True,
            )
    return int(failed)


def _rms(values: Array, bands: tuple[NDArray[np.bool_], ...]) -> Array:
    return np.array([np.sqrt((values[:, band] ** 2).mean()) for band in bands])


if __name__ == "__main__":
    raise SystemExit(main())
