"""List the uncertain values of a setup, with the uncertainty that it states or that is assumed."""

import math
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.calibrated_setup import agreeing, setup_key
from radargui.model.gravity import ASSUMED_AIR
from radargui.model.radar import Floor, Receiver, Tracer, Transmitter
from radargui.model.section import Section
from radargui.model.setup import Setup, moved

ASSUMED = {
    "u_tilt_deg": 0.5,
    "u_azimuth_deg": 0.5,
    "u_distance_m": 3e-3,
    "u_phase_centre_m": 0.02,
    "u_x_m": 3e-3,
    "u_y_m": 3e-3,
    "u_release_m": 1e-3,
    "u_release_scatter_m": 0.2e-3,
    "u_diameter_m": 0.02e-3,
    "u_refractive_index": 0.02,
    "u_polarization_deg": 5.0,
    "floor.u_tilt_deg": 0.3,
    "u_reflection": 0.05,
    "floor.u_size_m": 1e-3,
    "floor.u_azimuth_deg": 3.0,
    "floor.u_middle_m": 5e-3,
    "u_clock_ppm": 50.0,
    **ASSUMED_AIR,
}
"""Standard uncertainties where the setup gives none: antennas set up with protractor and tape, a sphere hung by hand
and measured with a calliper, a floor laid with a spirit level, the clock of NI's data sheets. Units as in the names."""
ASSUMED_FREQUENCY = 1e-6
"""The same of the frequency, relative: a synthesiser with a crystal."""
DIAMETER = "tracer.diameter_m"
OF_SPHERE = (DIAMETER, "tracer.refractive_index")
"""What the sphere scatters by."""
TILT, CLOCK, CONTACT = "floor.tilt_deg", "daq.clock_ppm", "floor.contact_s"
"""No keys of the setup: what `floor.u_tilt_deg` and `daq.u_clock_ppm` belong to, and how long an impact lasts."""
CONTACT_S = 1e-4
"""Root mean square of what an impact may last: a 10 mm steel sphere of 1 m/s touches steel or glass for 35 us, acrylic
for 140 us (Hertz; K. L. Johnson, Contact Mechanics, 11.4). Longer ones show in the plane of the impacts."""
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
        Dotted key, lists counted from 1: receiver[2].tilt_deg, tracer.release_position_m[3]. `floor.tilt_deg` and
        `daq.clock_ppm` are no keys of the setup; they name what `floor.u_tilt_deg` and `daq.u_clock_ppm` belong to.
    u_key
        Key that gives the uncertainty.
    u
        Standard uncertainty, in the unit that `u_key` ends with.
    assumed
        Whether the uncertainty is assumed, because the setup does not state it.
    together
        For a direction of a calibration's covariance, the keys that move together and by how much each moves; else
        empty.
    """

    key: str
    u_key: str
    u: float
    assumed: bool
    together: tuple[tuple[str, float], ...] = ()

    def moved(self, setup: Setup, share: float = 1.0) -> Setup:
        """Return the setup with this input moved by a share of its uncertainty, unchecked."""
        for key, by in self.together or ((self.key, self.u),):
            setup = moved(setup, key, share * by)
        return setup


def release_parts_m(tracer: Tracer) -> tuple[float, float]:
    """Return the uncertainty of a release that the drops of a session share, and that of each drop about it.

    A scatter that is not stated is a part of the stated uncertainty, which is that of a single drop.
    """
    u = u_release_m(tracer)
    scatter = tracer.u_release_scatter_m
    if scatter is None:
        scatter = min(ASSUMED["u_release_scatter_m"], u)
    return math.sqrt(max(u**2 - scatter**2, 0.0)), scatter


def u_release_m(tracer: Tracer) -> float:
    """Return the uncertainty of one drop's release, of each coordinate."""
    u = ASSUMED["u_release_m"] if tracer.u_release_m is None else tracer.u_release_m
    return u if tracer.u_release_scatter_m is None else math.hypot(u, tracer.u_release_scatter_m)


def usual_u(one: UncertainInput) -> float:
    """Return the uncertainty to which a laboratory usually knows an input; 0 if there is no usual one."""
    return ASSUMED.get(one.u_key.split(".")[-1], 0.0)


def uncertain_inputs(setup: Setup) -> tuple[UncertainInput, ...]:
    """Return every value of the setup that results depend on, with the uncertainty given or assumed.

    Values that a calibration found are uncertain together. They are replaced by the directions d of their covariance, C
    = sum of d d^T, so that squares of changes add up as for single values (JCGM 102, 6.2.1.3). Polarisations are
    included if the transmitter's is stated; else the sphere counts as a point.
    """
    polarized = setup.transmitter.polarization_deg is not None
    out: list[UncertainInput] = []

    def add(place: str, table: Section, u_name: str, *names: str, default: float = 0.0) -> None:
        given = getattr(table, u_name)
        u = ASSUMED.get(f"{place}.{u_name}", ASSUMED.get(u_name, default)) if given is None else given
        names = names or (u_name.removeprefix("u_"),)
        out.extend(UncertainInput(f"{place}.{name}", f"{place}.{u_name}", u, given is None) for name in names)

    add("radar", setup.radar, "u_frequency_hz", default=ASSUMED_FREQUENCY * setup.radar.frequency_hz)
    if setup.air.is_known:
        out.append(UncertainInput("radar.refractive_index", "air", setup.air.u_refractive_index, assumed=False))
    # taken as 1: off by what air has, always to the same side
    elif setup.radar.refractive_index is None:
        out.append(UncertainInput("radar.refractive_index", "radar.refractive_index", AIR_OVER_VACUUM, assumed=True))
    antennas = {"transmitter": setup.transmitter} | {f"receiver[{n}]": one for n, one in enumerate(setup.receiver, 1)}
    for place, antenna in antennas.items():
        for name in ("tilt_deg", "azimuth_deg", "distance_m", *(("polarization_deg",) if polarized else ())):
            if f"u_{name}" in type(antenna).model_fields:
                add(place, antenna, f"u_{name}")
    out = [_with_phase_centre(one, antennas.get(one.key.removesuffix(".distance_m"))) for one in out]
    add("transmitter", setup.transmitter, "u_x_m", "position_m[1]")
    add("transmitter", setup.transmitter, "u_y_m", "position_m[2]")
    add("tracer", setup.tracer, "u_diameter_m")
    if setup.tracer.index is not None:
        add("tracer", setup.tracer, "u_refractive_index")
    u_release, given = u_release_m(setup.tracer), setup.tracer.u_release_m is not None
    out.extend(
        UncertainInput(f"tracer.release_position_m[{axis}]", "tracer.u_release_m", u_release, not given)
        for axis in (1, 2, 3)
    )
    add("floor", setup.floor, "u_tilt_deg")
    add("daq", setup.daq, "u_clock_ppm")
    keys, directions = _of_calibration(setup)
    # a place that was found has its distance in the covariance already
    if any(key.startswith("transmitter.position_m") for key in keys):
        keys = (*keys, "transmitter.distance_m")
    # the antennas that were found stand about an axis on which it was held: z is that axis
    if any(key.startswith("transmitter.") for key in keys):
        keys = (*keys, "transmitter.position_m[1]", "transmitter.position_m[2]")
    return (*(one for one in out if one.key not in keys), *directions)


def _with_phase_centre(one: UncertainInput, antenna: Transmitter | Receiver | None) -> UncertainInput:
    """Return the uncertainty of an antenna's distance with that of its phase centre, which moves the same point."""
    return one if antenna is None else replace(one, u=math.hypot(one.u, u_phase_centre_m(antenna)))


def u_phase_centre_m(antenna: Transmitter | Receiver) -> float:
    """Return the uncertainty of how far behind its place an antenna's phase centre lies; 0 where they are one."""
    if antenna.phase_centre_m is None:
        return 0.0
    return ASSUMED["u_phase_centre_m"] if antenna.u_phase_centre_m is None else antenna.u_phase_centre_m


def _of_calibration(setup: Setup) -> tuple[tuple[str, ...], list[UncertainInput]]:
    """Return the keys whose covariance a calibration gives, and its directions.

    Values that were edited since keep their own u_, and so do polarisations, which are unknowns of the estimates.
    """
    content = setup.calibration.content
    # what moves by paths and by the sphere is told apart in the budget
    used = [] if content is None else [n for n in agreeing(setup) if not content.names[n].endswith("polarization_deg")]
    if content is None or not used:
        return (), []
    keys = tuple(setup_key(content.names[n]) for n in used)
    covariance = np.array(content.covariance)[np.ix_(used, used)]
    # a value that is exact has no u to divide by
    u = np.sqrt(np.diag(covariance)).clip(np.finfo(float).tiny)
    # of the correlations: degrees and metres have no common size
    values, vectors = np.linalg.eigh(covariance / np.outer(u, u))
    # rounding leaves eigenvalues a little below 0
    return keys, [
        UncertainInput(
            f"calibration[{n}]", "calibration.file", 1.0, False, tuple(zip(keys, direction.tolist(), strict=True))
        )
        for n, direction in enumerate((u[:, None] * vectors * np.sqrt(values.clip(0.0))).T, 1)
        if direction.any()
    ]


def assumed_uncertainties(setup: Setup) -> dict[str, float]:
    """Return the uncertainties that the setup does not give, by the key that would give them, and the values taken."""
    of_air = {f"air.{name}": u for name, u in setup.air.assumed.items()}
    floor = setup.floor
    of_floor = {"floor.u_reflection": u_reflection(floor)} if floor.is_stated and floor.u_reflection is None else {}
    if floor.size_m is not None:
        given = floor.u_size_m, floor.u_azimuth_deg, floor.u_middle_m
        named = zip(_OF_EDGES, given, u_of_edges(floor), strict=True)
        of_floor |= {key: u for key, stated, u in named if stated is None}
    return {one.u_key: one.u for one in uncertain_inputs(setup) if one.assumed} | of_air | of_floor


def u_reflection(floor: Floor) -> float:
    """Return the uncertainty of what a floor is said to reflect."""
    return ASSUMED["u_reflection"] if floor.u_reflection is None else floor.u_reflection


_OF_EDGES = ("floor.u_size_m", "floor.u_azimuth_deg", "floor.u_middle_m")


def u_of_edges(floor: Floor) -> tuple[float, float, float]:
    """Return the uncertainties of a plate's sides (m), of its azimuth (degrees) and of its middle's x and y (m)."""
    given = floor.u_size_m, floor.u_azimuth_deg, floor.u_middle_m
    size, azimuth, middle = (ASSUMED[key] if u is None else u for key, u in zip(_OF_EDGES, given, strict=True))
    return size, azimuth, middle
