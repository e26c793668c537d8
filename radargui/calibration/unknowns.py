"""The unknowns of a calibration: values of the setup with their priors, and what motions share."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from radargui.model.assumed import u_phase_centre_m
from radargui.model.errors import UsageError, worded
from radargui.model.gravity import drag_of_sphere, g_and_u_of_site, share_in_air
from radargui.model.setup import Setup, moved, value_of

GROUPS = ("tilt", "azimuth", "distance", "transmitter", "release", "gravity", "polarization")
"""What `--free` may name: `transmitter` is its place, `gravity` the direction of gravity. Polarisations that are not
named are unknowns of each recording, with the setup's prior (method 4)."""
POLARISATION, MIN_U_DEG = "polarization_deg", 1e-4
"""Key in a setup; a u of 0 counts as this, for no weight may be infinite (far below what can be measured)."""
USUAL = ("tilt", "azimuth", "distance", "release")
U_UNSTATED = {"tilt": 3.0, "azimuth": 3.0, "distance": 0.02, "release": 0.002, "polarization": 5.0}
"""Prior deviations (degrees, m) where the setup gives none: wide, since what nobody measured is what is asked for."""
U_PLUMB_DEG = 0.3
"""Of the vertical against the setup's z axis: a spirit level."""
U_HEIGHT_M, U_FLOOR_DEG = 0.5, 0.5
"""Of the floor's height where the setup gives none, and of its level."""
GRAVITY, DRAG, HEIGHT = "gravity.g_m_s2", "drag_1_m", "floor.height_m"
GRAVITY_X, GRAVITY_Y = "gravity.x_deg", "gravity.y_deg"
FLOOR_X, FLOOR_Y = "floor.x_deg", "floor.y_deg"


@dataclass(frozen=True, slots=True)
class Unknown:
    """One unknown.

    Attributes
    ----------
    name
        Key of the setup, receivers counted from 1 (`model.calibration`), or a name of its own.
    value, u
        Prior mean and deviation, in the unit of the name.
    group
        Its group as `--free` names it; empty: always unknown.
    key
        Its key for `model.setup.moved`; empty if it is no value of the setup.
    """

    name: str
    value: float
    u: float
    group: str = ""
    key: str = ""


def antenna_unknowns(setup: Setup, *, place: bool = False, polarised: bool = False) -> list[Unknown]:
    """Return the values of the antennas; the transmitter's three coordinates instead of its distance where asked."""
    sender = setup.transmitter
    u_sender = math.hypot(_given(sender.u_distance_m, "distance"), u_phase_centre_m(sender))
    if place:
        out = [
            Unknown(f"transmitter.position_m.{axis}", x, u_sender, "transmitter", f"transmitter.position_m[{n}]")
            for n, (axis, x) in enumerate(zip("xyz", sender.place_m, strict=True), 1)
        ]
    else:
        name = "transmitter.distance_m"
        out = [Unknown(name, value_of(setup, name), u_sender, "distance", name)]
    for n, one in enumerate(setup.receiver, 1):
        for name in ("tilt_deg", "azimuth_deg", "distance_m"):
            group = name.partition("_")[0]
            u = _given(getattr(one, f"u_{name}"), group)
            # who holds the distance by a u of zero and states a phase centre holds only the former
            u = math.hypot(u, u_phase_centre_m(one)) if name == "distance_m" else u
            out.append(Unknown(f"receiver.{n}.{name}", getattr(one, name), u, group, f"receiver[{n}].{name}"))
    if polarised:
        # all of them or none: one that is known exactly stays where it is
        named = {"transmitter": sender} | {f"receiver[{n}]": one for n, one in enumerate(setup.receiver, 1)}
        for place_of, own in named.items():
            u, key = max(_given(own.u_polarization_deg, "polarization"), MIN_U_DEG), f"{place_of}.{POLARISATION}"
            name = key.replace("[", ".").replace("]", "")
            out.append(Unknown(name, own.polarization_deg or 0.0, u, "polarization", key))
    # who gives a u of zero holds the value: it is no unknown
    return [one for one in out if one.u > 0.0]


def with_polarisations(setup: Setup) -> Setup:
    """Return the setup with each receiver's polarisation stated, so that it stays while the antennas move.

    Raises
    ------
    UsageError
        The setup states no polarisation of the transmitter: the sphere counts as a point.
    """
    if setup.transmitter.polarization_deg is None:
        raise worded(UsageError, "polarisation_not_free")
    pairs = zip(setup.receiver, setup.received_fields(), strict=True)
    receivers = tuple(one.model_copy(update={POLARISATION: field.angle_deg}) for one, field in pairs)
    return setup.model_copy(update={"receiver": receivers})


def place_unknowns(setup: Setup, place_m: Sequence[float], name: str) -> list[Unknown]:
    """Return the three coordinates of a place where the sphere hangs before it falls."""
    u = _given(setup.tracer.u_release_m, "release")
    return [Unknown(f"{name}.{axis}", x, u, "release") for axis, x in zip("xyz", place_m, strict=True)]


def fall_unknowns(setup: Setup) -> list[Unknown]:
    """Return the unknowns that all falls share: gravity in air and its direction, the drag, and the floor."""
    g, u_g = site_gravity(setup)
    floor = setup.floor
    drag = drag_of_sphere(setup.tracer.diameter_m, setup.tracer.density_kg_m3, setup.air.gas)
    leaning = U_FLOOR_DEG if floor.u_tilt_deg is None else floor.u_tilt_deg
    # for a floor that leans a little slope and angle are one
    slopes = [math.degrees(x / floor.normal[2]) for x in floor.normal[:2]]
    return [
        Unknown(GRAVITY, g, u_g),
        Unknown(GRAVITY_X, 0.0, U_PLUMB_DEG, "gravity"),
        Unknown(GRAVITY_Y, 0.0, U_PLUMB_DEG, "gravity"),
        Unknown(DRAG, drag.k_1_m, drag.u_k_1_m),
        # where the floor is known, it is known as the release is; else the impacts say it
        Unknown(HEIGHT, floor.height_m or 0.0, U_HEIGHT_M),
        Unknown(FLOOR_X, slopes[0], leaning),
        Unknown(FLOOR_Y, slopes[1], leaning),
    ]


def site_gravity(setup: Setup) -> tuple[float, float]:
    """Return the acceleration of the falling sphere at the site, with buoyancy, and its uncertainty."""
    g, u = g_and_u_of_site(setup.site)
    # a site that calls its g exact: the unknown stays one, with a prior that hardly lets it move
    return g * share_in_air(setup.tracer.density_kg_m3, setup.air.gas), max(u, 1e-6)


def _given(u: float | None, group: str) -> float:
    return U_UNSTATED[group] if u is None else u


def chosen_groups(text: str | None) -> tuple[str, ...]:
    """Return the groups that `--free` names.

    Raises
    ------
    UsageError
        A name is unknown.
    """
    names = USUAL if text is None else tuple(part.strip() for part in text.split(","))
    wrong = [name for name in names if name not in GROUPS]
    if wrong:
        raise UsageError(f"--free = {', '.join(wrong)!r}, allowed: {', '.join(GROUPS)}")
    return names


def setup_with(setup: Setup, unknowns: Sequence[Unknown], values: Mapping[str, float]) -> Setup:
    """Return the setup with the antennas where the values say, unchecked."""
    if any(one.key.startswith("transmitter.position_m") for one in unknowns):
        sender = setup.transmitter
        sender = sender.model_copy(update={"position_m": sender.place_m, "distance_m": None})
        setup = setup.model_copy(update={"transmitter": sender})
    for one in unknowns:
        if one.key and one.name in values and values[one.name] != one.value:
            setup = moved(setup, one.key, values[one.name] - one.value)
    return setup
