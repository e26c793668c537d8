"""What the report says about the setup: antennas, sphere, acquisition, the matrix T."""

from radargui.geometry.antennas import place_antennas
from radargui.geometry.plane_wave import condition_number, t_matrix
from radargui.model.radar import Transmitter
from radargui.model.rounding import plain, quantity
from radargui.model.setup import Setup
from radargui.report.document import Content, Facts, Grid, Note

_LEAST_RECEIVERS = 3
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
    floor = setup.floor.height_m
    rows = (
        (
            "Frequency, wavelength",
            f"{radar.frequency_hz / 1e9:g} GHz, {plain(radar.wavelength_m, 5, 'mm', 1e3)}"
            + (f" (n = {radar.refractive_index:g})" if radar.refractive_index else ", the air taken as vacuum"),
        ),
        ("Sign of the phase", f"{radar.phase_sign:+d}"),
        ("Transmitter", _transmitter(setup.transmitter)),
        (
            "Sphere",
            f"{_with_u(tracer.diameter_m, tracer.u_diameter_m, 'mm', 1e3)} diameter, released at ({release}) mm"
            + (f", {tracer.density_kg_m3:g} kg/m³" if tracer.density_kg_m3 else ""),
        ),
        ("Floor", f"z = {plain(floor, 4, 'mm', 1e3)} at contact" if floor is not None else "found from the impacts"),
        *((("Acquisition", f"simulated, {rate}"),) if simulated else ()),
        *(_acquisition(setup, rate) if recorded else ()),
        ("Processing", f"correction {setup.processing.correction}, geometry {setup.processing.geometry}"),
    )
    blocks: list[Content] = [Facts(rows, "Setup"), _receivers(setup)]
    if setup.n_receivers >= _LEAST_RECEIVERS:
        blocks += _matrix(setup)
    return blocks


def _transmitter(transmitter: Transmitter) -> str:
    distance = transmitter.distance_m
    if distance is None:
        place = f"at ({', '.join(f'{1e3 * x:g}' for x in transmitter.place_m)}) mm"
    else:
        place = f"{_with_u(distance, transmitter.u_distance_m, 'mm', 1e3)} above the centre"
    if transmitter.polarization_deg is None:
        return f"{place}; polarisation not given: the sphere counts as a point"
    return f"{place}, polarised along {_with_u(transmitter.polarization_deg, transmitter.u_polarization_deg, '°')}"


def _acquisition(setup: Setup, rate: str) -> tuple[tuple[str, str], ...]:
    daq = setup.daq
    return (
        ("Acquisition", f"{daq.device}: {', '.join(setup.physical_channels)}; {daq.terminal}, ±{daq.range_v:g} V"),
        ("Rate", f"{rate}, skew {plain(daq.channel_skew_s, 3, 'µs', 1e6)}"),
    )


def _with_u(value: float, u: float | None, unit: str = "", scale: float = 1.0) -> str:
    return quantity(value, u, unit, scale) if u else f"{value * scale:g} {unit}".strip()


def _receivers(setup: Setup) -> Grid:
    rows = tuple(
        (
            str(number),
            _with_u(receiver.tilt_deg, receiver.u_tilt_deg),
            _with_u(receiver.azimuth_deg, receiver.u_azimuth_deg),
            _with_u(receiver.distance_m, receiver.u_distance_m, scale=1e3),
        )
        for number, receiver in enumerate(setup.receiver, 1)
    )
    return Grid(("receiver", "tilt / °", "azimuth / °", "distance / mm"), rows, "Receivers")


def _matrix(setup: Setup) -> list[Content]:
    antennas = place_antennas(setup)
    rows = tuple((str(number), *(f"{value:.5f}" for value in row)) for number, row in enumerate(t_matrix(antennas), 1))
    condition = condition_number(antennas)
    return [
        Grid(("receiver", "sin t cos a", "sin t sin a", "1 + cos t"), rows, "Matrix T (plane wave)"),
        Note(f"Condition number of T: {condition:.3f}", warning=condition > _WORST_CONDITION),
    ]
