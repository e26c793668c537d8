"""Where each global parameter stands in the vector theta (method 4: symbols), and the receivers' constants."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import lru_cache

import numpy as np

from radargui.model.arrays import FloatArray, IntArray
from radargui.physics.edges import N_EDGES

N_LOBE = 3
"""Functions by which an antenna's lobe changes what comes directly and over a floor, and over each wall (`lobes`)."""


@dataclass(frozen=True, slots=True)
class ReceiverConstants:
    """What a receiver's signal needs where nothing depends on position or time, in the order of the layout.

    Attributes
    ----------
    phase_rad
        phi_0, phase at the release position.
    log_amplitude
        ln A at the release position, A in units of the scaled samples.
    offset_i, offset_q
        c, in units of the scaled samples; the mean of the bias counts as offset.
    log_gain
        ln g.
    quadrature_error_rad
        eps.
    """

    phase_rad: float
    log_amplitude: float
    offset_i: float
    offset_q: float
    log_gain: float
    quadrature_error_rad: float

    def in_order(self) -> FloatArray:
        """Return them as they stand at `ReceiverLayout.constants`, shape (6,)."""
        return np.array(astuple(self))


@dataclass(frozen=True, slots=True)
class ReceiverLayout:
    """Places of one receiver's unknowns in theta.

    Attributes
    ----------
    phase, log_amplitude, offset, log_gain, quadrature_error
        Its constants, see `ReceiverConstants`; the offset has two places, I and Q.
    harmonics
        Real and imaginary parts of what the mixer makes of the echo that turns at -3 and +3 times its phase.
    bias_i, bias_q, amplitude_map
        Coefficients of the maps of bias (real and imaginary part of beta) and of log amplitude.
    receiver_reflection, double_reflection
        Real and imaginary parts of R and X by turns, two a mirror.
    receiver_lobe
        How the antenna's lobe shows the tracer: `N_LOBE` directly and over a floor, and as many over each wall.
    polarization
        Angle of the antenna (rad), one place; none where the sphere counts as a point.
    drift_i, drift_q
        Coefficients of the slow noise of each channel.
    """

    phase: int
    log_amplitude: int
    offset: slice
    log_gain: int
    quadrature_error: int
    harmonics: slice
    bias_i: slice
    bias_q: slice
    amplitude_map: slice
    receiver_reflection: slice
    receiver_lobe: slice
    double_reflection: slice
    polarization: slice
    drift_i: slice
    drift_q: slice

    @property
    def first(self) -> int:
        """First place of this receiver."""
        return self.phase

    @property
    def last(self) -> int:
        """One past the last place of this receiver."""
        return int(self.drift_q.stop)

    @property
    def constants(self) -> slice:
        """Places of the constants, in the order of `ReceiverConstants`."""
        return slice(self.phase, self.quadrature_error + 1)

    @property
    def without_drift(self) -> slice:
        """Places of all but the slow noise."""
        return slice(self.phase, self.drift_i.start)


@dataclass(frozen=True, slots=True)
class Sizes:
    """Numbers of breaks, mirrors, receivers, functions of a bias and an amplitude map, of slow noise; angles, kappa.

    `flight` is 1 where something flies; `walls` is how many of the mirrors are no floor; `setup` how many values of the
    setup are unknown; `edges` is 1 where the floor is a plate whose edges are.
    """

    breaks: int
    mirrors: int
    receivers: int
    bias: int
    amplitude_map: int
    drift: int
    polarization: int = 0
    crosstalk: int = 0
    flight: int = 0
    walls: int = 0
    setup: int = 0
    edges: int = 0


@dataclass(frozen=True, slots=True)
class Layout:
    """Places of all global parameters: breaks, mirrors as the receivers share them, then the receivers.

    Attributes
    ----------
    breaks
        Times of the breaks.
    flight
        Acceleration of gravity g_x, g_y, g_z (m/s^2) and drag k (1/m); none where nothing flies.
    planes
        Three a mirror: two tilts and a shift.
    transmitter_reflection
        Real and imaginary part of T by turns, two a mirror.
    exchange
        Real and imaginary part of R for what sphere and floor send to and fro, over T; none without a floor and of a
        point.
    edges
        Half of both sides of a plate (m), azimuth of the first (rad), x and y of its middle (m); none of a floor that
        goes on.
    transmitter_lobe
        The same of the transmitter.
    polarization
        Angle of the transmitter (rad), one place; none where the sphere counts as a point.
    crosstalk
        kappa of the multiplexer, one place or none.
    setup
        Antennas, release and wavelength in standard uncertainties from what the setup states; none where nothing flies.
    receivers
        One a receiver.
    sizes
        The numbers it was made from.
    size
        Length of theta.
    """

    breaks: slice
    flight: slice
    planes: slice
    transmitter_reflection: slice
    exchange: slice
    edges: slice
    transmitter_lobe: slice
    polarization: slice
    crosstalk: slice
    setup: slice
    receivers: tuple[ReceiverLayout, ...]
    sizes: Sizes
    size: int

    @property
    def shared(self) -> slice:
        """Places of what the receivers share besides the motion: mirrors, the transmitter's angle, crosstalk, setup."""
        return slice(self.planes.start, self.setup.stop)

    @property
    def mirrors(self) -> slice:
        """Places of what the sphere's scattering hangs on: the planes' unknowns, T, R of the exchange."""
        return slice(self.planes.start, self.exchange.stop)

    @property
    def own(self) -> ReceiverLayout:
        """Places of a receiver's unknowns among its own, see `own_values`."""
        return _own_layout(self.sizes)

    def own_values(self, theta: FloatArray, receiver: int | slice) -> FloatArray:
        """Return the own unknowns of a receiver, shape (n_own,), or of some, shape (n_receivers, n_own)."""
        block = theta[self.receivers[0].first : self.receivers[-1].last]
        return np.asarray(block.reshape(len(self.receivers), -1)[receiver])

    def plane_unknowns(self, theta: FloatArray) -> FloatArray:
        """Return two tilts (rad) and the shift (m) of each mirror, shape (n_mirrors, 3)."""
        return np.asarray(theta[self.planes].reshape(-1, 3))


def of_mirror(places: slice, mirror: int) -> slice:
    """Return the two places of one mirror among places of two a mirror."""
    return slice(places.start + 2 * mirror, places.start + 2 * mirror + 2)


def lobe_places(layout: Layout) -> IntArray:
    """Return the places of what lobes do directly and over mirrors, the transmitter's first, shape (n,)."""
    places = [layout.transmitter_lobe, *(own.receiver_lobe for own in layout.receivers)]
    return np.concatenate([np.arange(one.start, one.stop) for one in places])


def polarisation_places(layout: Layout) -> IntArray:
    """Return the places of the antennas' angles, (1 + n_receivers,), the transmitter's first; none for a point."""
    places = [layout.polarization, *(own.polarization for own in layout.receivers)]
    return np.concatenate([np.arange(one.start, one.stop) for one in places])


def with_nearest_angles(theta: FloatArray, layout: Layout, mean: FloatArray) -> FloatArray:
    """Return theta, (n_global,), with every polarisation's angle within a quarter turn of that in `mean`.

    After half a turn a linear polarisation is minus itself, which phi_0 takes: the signal is the same.
    """
    places = polarisation_places(layout)
    turns = np.round((theta[places] - mean[places]) / np.pi)
    if not turns.any():
        return theta
    out = theta.copy()
    out[places] -= np.pi * turns
    return out


def make_layout(sizes: Sizes) -> Layout:
    """Return the layout for these numbers of unknowns."""
    take = _Taken()
    two_a_mirror, lobe_places = 2 * sizes.mirrors, N_LOBE * (1 + sizes.walls)
    n_floors = sizes.mirrors - sizes.walls
    exchanged, edges_places = 2 * n_floors * sizes.polarization, N_EDGES * n_floors * sizes.edges
    of_mirrors = 3 * sizes.mirrors, two_a_mirror, exchanged, edges_places
    shared = (*of_mirrors, lobe_places, sizes.polarization, sizes.crosstalk, sizes.setup)
    # breaks first: where their number changes all that follows moves by it
    breaks, flight = take(sizes.breaks), take(4 * sizes.flight)
    # shared unknowns stand together: every receiver's data touch them, its own touch no other receiver
    planes, reflection, exchange, edges, lobe, polarization, crosstalk, setup = (take(count) for count in shared)
    receivers = tuple(_receiver_layout(sizes, take) for _ in range(sizes.receivers))
    own = planes, reflection, exchange, edges, lobe, polarization, crosstalk, setup
    return Layout(breaks, flight, *own, receivers, sizes, take.end)


class _Taken:
    """Places given away one after the other."""

    def __init__(self) -> None:
        self.end = 0

    def __call__(self, count: int) -> slice:
        self.end += count
        return slice(self.end - count, self.end)


def _receiver_layout(sizes: Sizes, take: _Taken) -> ReceiverLayout:
    two_a_mirror = 2 * sizes.mirrors
    return ReceiverLayout(
        phase=take(1).start,
        log_amplitude=take(1).start,
        offset=take(2),
        log_gain=take(1).start,
        quadrature_error=take(1).start,
        harmonics=take(4),
        bias_i=take(sizes.bias),
        bias_q=take(sizes.bias),
        amplitude_map=take(sizes.amplitude_map),
        receiver_reflection=take(two_a_mirror),
        receiver_lobe=take(N_LOBE * (1 + sizes.walls)),
        double_reflection=take(two_a_mirror),
        polarization=take(sizes.polarization),
        drift_i=take(sizes.drift),
        drift_q=take(sizes.drift),
    )


@lru_cache(maxsize=64)
def _own_layout(sizes: Sizes) -> ReceiverLayout:
    return _receiver_layout(sizes, _Taken())
