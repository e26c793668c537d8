"""What the setup's values are uncertain by: what it says, else what a laboratory is assumed to know."""

from dataclasses import dataclass

from radargui.model.section import Section
from radargui.model.setup import Setup

ASSUMED = {
    "u_tilt_deg": 0.5,
    "u_azimuth_deg": 0.5,
    "u_distance_m": 3e-3,
    "u_release_m": 1e-3,
    "u_diameter_m": 0.02e-3,
    "u_polarization_deg": 5.0,
    "floor.u_tilt_deg": 0.3,
    "u_clock_ppm": 50.0,
}
"""Standard uncertainties where the setup gives none: antennas set up with protractor and tape, a sphere hung by hand
and measured with a calliper, a floor laid with a spirit level, the clock of NI's data sheets. Units as in the names."""
ASSUMED_FREQUENCY = 1e-6
"""The same of the frequency, relative: a synthesiser with a crystal."""
TILT, CLOCK = "floor.tilt_deg", "daq.clock_ppm"
"""No keys of the setup: what `floor.u_tilt_deg` and `daq.u_clock_ppm` belong to."""
SUPPOSED_POLARIZATIONS_DEG = (0.0, 45.0, 90.0, 135.0)
"""Of the transmitter, tried in turn where none is given: the field turns on itself after 180 degrees."""
SUPPOSED_TURNS_DEG = (-55.0, 55.0)
"""How far the receivers are turned from the strongest signal then: half of the signal's angles lie beyond 45, and the
phase changes most with position where a receiver gets little. Turned for the strongest the share was too small by 2."""
AIR_OVER_VACUUM = 3.2e-4
"""n - 1 of air (ITU-R P.453 at 20 degrees C, 1013 hPa, half humid): what is not known where the setup names no n."""


@dataclass(frozen=True, slots=True)
class UncertainInput:
    """One value of the setup and its standard uncertainty.

    Attributes
    ----------
    key
        Dotted, lists counted from 1: receiver[2].tilt_deg, tracer.release_position_m[3]. `floor.tilt_deg` and
        `daq.clock_ppm` are no keys of the setup but what those uncertainties belong to.
    u_key
        Key that gives the uncertainty.
    u
        Standard uncertainty, in the unit that `u_key` ends with.
    assumed
        Whether the setup does not give it.
    """

    key: str
    u_key: str
    u: float
    assumed: bool


def uncertain_inputs(setup: Setup) -> tuple[UncertainInput, ...]:
    """Return every value of the setup that results depend on, with the uncertainty given or assumed.

    Polarisations are among them where the transmitter's is given: else the sphere counts as a point.
    """
    polarized = setup.transmitter.polarization_deg is not None
    out: list[UncertainInput] = []

    def add(place: str, table: Section, u_name: str, *names: str, default: float = 0.0) -> None:
        given = getattr(table, u_name)
        u = ASSUMED.get(f"{place}.{u_name}", ASSUMED.get(u_name, default)) if given is None else given
        names = names or (u_name.removeprefix("u_"),)
        out.extend(UncertainInput(f"{place}.{name}", f"{place}.{u_name}", u, given is None) for name in names)

    add("radar", setup.radar, "u_frequency_hz", default=ASSUMED_FREQUENCY * setup.radar.frequency_hz)
    # taken as 1: off by what air has, always to the same side
    if setup.radar.refractive_index is None:
        out.append(UncertainInput("radar.refractive_index", "radar.refractive_index", AIR_OVER_VACUUM, assumed=True))
    antennas = {"transmitter": setup.transmitter} | {f"receiver[{n}]": one for n, one in enumerate(setup.receiver, 1)}
    for place, antenna in antennas.items():
        for name in ("tilt_deg", "azimuth_deg", "distance_m", *(("polarization_deg",) if polarized else ())):
            if f"u_{name}" in type(antenna).model_fields:
                add(place, antenna, f"u_{name}")
    add("tracer", setup.tracer, "u_diameter_m")
    add("tracer", setup.tracer, "u_release_m", *(f"release_position_m[{axis}]" for axis in (1, 2, 3)))
    add("floor", setup.floor, "u_tilt_deg")
    add("daq", setup.daq, "u_clock_ppm")
    return tuple(out)


def assumed_uncertainties(setup: Setup) -> dict[str, float]:
    """Return the uncertainties that the setup does not give, by the key that would give them, and the values taken."""
    return {one.u_key: one.u for one in uncertain_inputs(setup) if one.assumed}
