"""Write what the report says of a setup: antennas, sphere, acquisition, calibration."""

from collections.abc import Iterator

import numpy as np

from radargui.geometry.path_length import LEAST_RECEIVERS, condition_number, place_antennas, t_matrix
from radargui.model.air import Air
from radargui.model.calibrated_setup import (
    CORRELATED,
    calibration_words,
    correlations,
    edited_since,
    setup_key,
    unit_of,
    value_at,
)
from radargui.model.radar import Transmitter
from radargui.model.rounding import UNKNOWN, plain, quantity
from radargui.model.setup import Setup
from radargui.model.words import sentence
from radargui.report.content import Content, Facts, Grid, Note

_MOST_NAMED = 8
"""Pairs in a sentence (chosen by hand); the others are counted."""
_WORST_CONDITION = 100.0
"""From here an error of L may reach the position a hundredfold."""


def setup_blocks(setup: Setup, *, recorded: bool = True, simulated: bool = False) -> list[Content]:
    """Return what the report says about the setup.

    Parameters
    ----------
    setup
        Of the session.
    recorded
        Whether the setup's device recorded: imported runs were digitised by something else, of which it knows nothing.
    simulated
        Whether no device recorded at all.
    """
    radar, tracer = setup.radar, setup.tracer
    rate = f"{setup.daq.rate_hz:g} samples per second and channel"
    release = ", ".join(f"{1e3 * x:g}" for x in tracer.release_position_m)
    floor, daq = setup.floor.height_m, setup.daq
    index = f" (n = {radar.index:.8g})" if radar.index > 1.0 else ", the air taken as vacuum"
    density = f", {tracer.density_kg_m3:g} kg/m³" if tracer.density_kg_m3 else ""
    diameter = _with_u(tracer.diameter_m, tracer.u_diameter_m, "mm", 1e3)
    inputs = f"{daq.device}: {', '.join(setup.physical_channels)}; {daq.terminal}, ±{daq.range_v:g} V"
    rows = {
        "Frequency, wavelength": f"{radar.frequency_hz / 1e9:g} GHz, {plain(radar.wavelength_m, 5, 'mm', 1e3)}{index}",
        "Air": _air(setup.air),
        "Sign of the phase": f"{radar.phase_sign:+d}",
        "Transmitter": _transmitter(setup.transmitter),
        "Sphere": f"{diameter} diameter, released at ({release}) mm{density}",
        "Floor": "found from the impacts" if floor is None else f"z = {plain(floor, 4, 'mm', 1e3)} at contact",
        "Acquisition": f"simulated, {rate}" if simulated else inputs if recorded else "",
        "Rate": f"{rate}, skew {plain(daq.channel_skew_s, 3, 'µs', 1e6)}" if recorded else "",
        "Processing": f"correction {setup.processing.correction}, geometry {setup.processing.geometry}",
    }
    return [Facts.of(rows, "Setup"), _receivers(setup), *_calibration(setup), *_matrix(setup)]


def _transmitter(transmitter: Transmitter) -> str:
    distance = transmitter.distance_m
    if distance is None:
        place = f"at ({', '.join(f'{1e3 * x:g}' for x in transmitter.place_m)}) mm"
    else:
        place = f"{_with_u(distance, transmitter.u_distance_m, 'mm', 1e3)} above the centre"
    if transmitter.polarization_deg is None:
        return f"{place}; polarisation not given: the sphere counts as a point"
    return f"{place}, polarised along {_with_u(transmitter.polarization_deg, transmitter.u_polarization_deg, '°')}"


def _air(air: Air) -> str:
    """Return the state of the air and what follows from it; empty where the setup does not say it."""
    if not air.is_known:
        return ""
    gas = air.gas
    state = ", ".join(
        _with_u(value or 0.0, u, unit)
        for value, u, unit in (
            (air.temperature_c, air.u_temperature_c, "°C"),
            (air.pressure_hpa, air.u_pressure_hpa, "hPa"),
            (air.humidity_percent, air.u_humidity_percent, "% humidity"),
        )
    )
    return (
        f"{state}: n − 1 = {quantity(air.refractive_index - 1.0, air.u_refractive_index, 'ppm', 1e6)} (Rüeger 2002), "
        f"density {quantity(gas.density_kg_m3, gas.u_density_kg_m3, 'kg/m³')}, "
        f"viscosity {plain(gas.viscosity_m2_s, 3, 'mm²/s', 1e6)}"
    )


def _with_u(value: float, u: float | None, unit: str = "", scale: float = 1.0) -> str:
    return quantity(value, u, unit, scale) if u else f"{value * scale:g} {unit}".strip()


def _receivers(setup: Setup) -> Grid:
    rows = (
        {
            "receiver": str(number),
            "tilt / °": _with_u(receiver.tilt_deg, receiver.u_tilt_deg),
            "azimuth / °": _with_u(receiver.azimuth_deg, receiver.u_azimuth_deg),
            "distance / mm": _with_u(receiver.distance_m, receiver.u_distance_m, scale=1e3),
        }
        for number, receiver in enumerate(setup.receiver, 1)
    )
    return Grid.of(rows, "Receivers")


def _calibration(setup: Setup) -> Iterator[Content]:
    """Give the table of what a calibration found, and which of it is known only together."""
    content = setup.calibration.content
    if content is None or not content.names:
        return
    covariance = np.array(content.covariance)
    u = np.sqrt(np.diag(covariance))
    rows = (
        {
            "parameter": setup_key(name),
            "unit": unit,
            "value ± u": quantity(value, own, scale=scale),
            "in the setup": plain(value_at(setup, name), 6, scale=scale),
        }
        for name, value, own in zip(content.names, content.values, u.tolist(), strict=True)
        for unit, scale in [unit_of(name)]
    )
    words = calibration_words(setup)
    yield Note(sentence(f"{words}: {content.reason or UNKNOWN}"))
    yield Grid.of(rows, "Calibration", left=(0, 1))
    pairs = [
        f"{setup_key(a)} with {setup_key(b)}: {r:+.2f}"
        for a, b, r in correlations(covariance, content.names, CORRELATED)
    ]
    named = "; ".join(pairs[:_MOST_NAMED]) + (f" and {len(pairs) - _MOST_NAMED} more" * (len(pairs) > _MOST_NAMED))
    if pairs:
        yield Note(f"Correlated by more than {CORRELATED:g}: {named}.")
    if edited := edited_since(setup):
        yield Note(sentence(edited.text), warning=True)


def _matrix(setup: Setup) -> Iterator[Content]:
    if setup.n_receivers < LEAST_RECEIVERS:
        return
    antennas = place_antennas(setup)
    rows = tuple((str(number), *(f"{value:.5f}" for value in row)) for number, row in enumerate(t_matrix(antennas), 1))
    condition = condition_number(antennas)
    yield Grid(("receiver", "sin t cos a", "sin t sin a", "1 + cos t"), rows, "Matrix T (plane wave)")
    yield Note(f"Condition number of T: {condition:.3f}", warning=condition > _WORST_CONDITION)
