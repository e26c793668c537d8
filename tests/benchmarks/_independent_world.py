"""A continuous-wave bistatic radar and a bouncing metal sphere, from textbooks alone; it knows nothing of the program.

Fields have the time factor exp(-i w t), so a path L turns a phase by +K L. The sphere scatters by multipoles (Jackson,
ch. 9 and 10: X_lm, regular and outgoing M and N), the floor mirrors by Fresnel's coefficients of a plate, and what they
send to and fro is the sphere coupled to its own image. All vectors are columns of shape (n, 3).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.special import sph_harm_y, spherical_jn, spherical_yn

LIGHT_M_S = 299792458.0
AIR_DENSITY, AIR_VISCOSITY = 1.19, 1.83e-5
FLIP = np.array([1.0, 1.0, -1.0])


def unit(v):
    """Return vectors of length one."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


# ------------------------------------------------------------------ the sphere
def radial(order, x):
    """Return j_l, h_l, (x j_l)' / x and (x h_l)' / x."""
    j, dj = spherical_jn(order, x), spherical_jn(order, x, True)
    h, dh = j + 1j * spherical_yn(order, x), dj + 1j * spherical_yn(order, x, True)
    return j, h, j / x + dj, h / x + dh


def modes(top):
    """Return all (l, m) up to an order."""
    return [(order, m) for order in range(1, top + 1) for m in range(-order, order + 1)]


def harmonics(direction, pairs):
    """Return X_lm in the directions, shape (n, number of pairs, 3)."""
    x, y, z = direction.T
    rho = np.hypot(x, y)
    # no direction is exactly that of the axis, where the angle about it is undefined
    theta, phi = np.arctan2(np.maximum(rho, 1e-7), z), np.arctan2(y, x)
    to_theta = np.stack([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)], axis=1)
    to_phi = np.stack([-np.sin(phi), np.cos(phi), np.zeros_like(phi)], axis=1)
    result = np.empty((len(direction), len(pairs), 3), complex)
    for at, (order, m) in enumerate(pairs):
        value, slope = sph_harm_y(order, m, theta, phi, diff_n=1)
        along = (slope[..., 0][:, None] * to_phi) - (1j * m / np.sin(theta) * value)[:, None] * to_theta
        result[:, at] = -1j * along / np.sqrt(order * (order + 1))
    return result


def translation(top, m, k, radius, lift):
    """Return what outgoing waves from `lift` below are as regular ones here: M to M and M to N, (n, l, l') each.

    By projection on the sphere of this radius; Gauss over the height, the angle about the axis is done by hand.
    """
    orders = range(max(1, abs(m)), top + 1)
    nodes, weights = np.polynomial.legendre.leggauss(3 * top + 16)
    here = np.stack([np.sqrt(1 - nodes**2), 0 * nodes, nodes], axis=1)
    own = harmonics(here, [(order, m) for order in orders])
    far = (radius * here)[None] + np.stack([0 * lift, 0 * lift, lift], axis=1)[:, None]
    distance = np.linalg.norm(far, axis=2)
    towards = far / distance[..., None]
    pairs = [(order, m) for order in orders]
    theirs = harmonics(towards.reshape(-1, 3), pairs).reshape(*distance.shape, len(pairs), 3)
    shape = (len(lift), len(pairs), len(pairs))
    same, other = np.empty(shape, complex), np.empty(shape, complex)
    for column, order in enumerate(orders):
        _, h, _, slope = radial(order, k * distance)
        harmonic = theirs[:, :, column]
        wave_m = h[..., None] * harmonic
        # curl (h X) / k = i sqrt(l (l+1)) h / kr Y r + slope (r x X)
        value = sph_harm_y(order, m, np.arccos(towards[..., 2]), np.arctan2(towards[..., 1], towards[..., 0]))
        along = 1j * np.sqrt(order * (order + 1)) * h / (k * distance) * value
        wave_n = along[..., None] * towards + slope[..., None] * np.cross(towards, harmonic)
        for row, to in enumerate(orders):
            factor = 2 * np.pi * weights / spherical_jn(to, k * radius)
            same[:, row, column] = np.einsum("q,qc,nqc->n", factor, own[:, row].conj(), wave_m)
            other[:, row, column] = np.einsum("q,qc,nqc->n", factor, own[:, row].conj(), wave_n)
    return same, other


@dataclass
class Sphere:
    """A conducting sphere, alone or over its image: what it scatters of plane waves."""

    radius: float
    k: float
    height: np.ndarray | None = None
    """Of its centre over the plane, (n,); None: what it and its image exchange is left out."""
    exchange: complex = 1.0
    """Share of a conductor's image in that."""

    def __post_init__(self):
        x = self.k * self.radius
        self.top = int(np.ceil(x + 4 * x ** (1 / 3))) + 1
        self.pairs = modes(self.top)
        tables = [radial(order, x) for order, _ in self.pairs]
        self.t_m = np.array([-one[0] / one[1] for one in tables])
        self.t_n = np.array([-one[2] / one[3] for one in tables])
        self.power = np.array([order for order, _ in self.pairs])

    def excited(self, direction, electric):
        """Return the coefficients (M, N) of the scattered wave for a plane wave along a direction, (n, modes)."""
        basis = harmonics(direction, self.pairs).conj()
        scale = 4 * np.pi * 1j**self.power
        turned = 1j * np.cross(direction, electric)
        into_m = scale * np.einsum("nmc,nc->nm", basis, electric)
        into_n = scale * np.einsum("nmc,nc->nm", basis, turned)
        return into_m, into_n

    def answered(self, into_m, into_n):
        """Return the outgoing coefficients for incident ones, with the exchange with the image where there is one."""
        if self.height is None:
            return self.t_m * into_m, self.t_n * into_n
        out_m, out_n = np.empty_like(into_m), np.empty_like(into_n)
        for m in range(-self.top, self.top + 1):
            at = np.array([i for i, pair in enumerate(self.pairs) if pair[1] == m])
            same, other = self._between(m)
            mirrored = -self.exchange * (-1.0) ** (self.power[at] + m)
            size = len(at)
            # the mirror turns M, which curls, the other way
            coupling = np.empty((len(self.height), 2 * size, 2 * size), complex)
            coupling[:, :size, :size] = same * -mirrored
            coupling[:, size:, :size] = other * -mirrored
            coupling[:, :size, size:] = other * mirrored
            coupling[:, size:, size:] = same * mirrored
            t = np.concatenate([self.t_m[at], self.t_n[at]])
            incident = np.concatenate([into_m[:, at], into_n[:, at]], axis=1)
            found = np.linalg.solve(np.eye(2 * size) - t[:, None] * coupling, (t * incident)[..., None])[..., 0]
            out_m[:, at], out_n[:, at] = found[:, :size], found[:, size:]
        return out_m, out_n

    def _between(self, m):
        """Return the translations from the image at each height, by a curve through some where there are many."""
        low, high = self.height.min(), self.height.max()
        if len(self.height) < 400 or high / low < 1.0001:
            return translation(self.top, m, self.k, self.radius, 2 * self.height)
        grid = np.geomspace(low, high, 300)
        turn = np.exp(-2j * self.k * grid)[:, None, None]
        both = np.stack(translation(self.top, m, self.k, self.radius, 2 * grid), axis=1) * turn[:, None]
        curve = CubicSpline(np.log(grid), both)(np.log(self.height))
        curve *= np.exp(2j * self.k * self.height)[:, None, None, None]
        return curve[:, 0], curve[:, 1]

    def sent(self, out, direction):
        """Return the field (n, 3) in a direction, times r exp(-i k r)."""
        basis = harmonics(direction, self.pairs)
        scale = (-1j) ** (self.power + 1) / self.k
        along = np.einsum("nm,nmc->nc", scale * out[0], basis)
        return along + 1j * np.cross(direction, np.einsum("nm,nmc->nc", scale * out[1], basis))


# ------------------------------------------------------------------ the floor
@dataclass
class Plate:
    """A plate: refractive index, thickness, what it lies on (None: a conductor); index None: a conductor itself."""

    index: complex | None
    thickness: float = 0.01
    backing: complex | None = 1.0
    share: float = 1.0
    """Of it all: 0 of an absorber."""

    def coefficients(self, k, cosine):
        """Return what stays of the field across (TE) and, along the mirrored direction, in the plane (TM)."""
        if self.index is None:
            both = -self.share * np.ones(np.shape(cosine), complex)
            return both, both
        sine2 = 1 - np.asarray(cosine) ** 2

        def inner(n):
            return np.sqrt(n**2 - sine2 + 0j)

        a, b = np.asarray(cosine) + 0j, inner(self.index)
        turn = np.exp(2j * k * self.thickness * b)
        first = (a - b) / (a + b), (a * self.index**2 - b) / (a * self.index**2 + b)
        if self.backing is None:
            second = -np.ones_like(b), np.ones_like(b)
        else:
            c, n1, n2 = inner(self.backing), self.index**2, self.backing**2
            second = (b - c) / (b + c), (b * n2 - c * n1) / (b * n2 + c * n1)
        te, tm = [(p + q * turn) / (1 + p * q * turn) for p, q in zip(first, second, strict=True)]
        return self.share * te, -self.share * tm

    def reflect(self, k, direction, electric):
        """Return the field after the mirror of waves that go along `direction`, downwards."""
        across = np.cross(direction, [0.0, 0.0, 1.0])
        size = np.linalg.norm(across, axis=1, keepdims=True)
        across = np.where(size > 1e-9, across / np.maximum(size, 1e-9), [1.0, 0.0, 0.0])
        within = np.cross(across, direction)
        te, tm = self.coefficients(k, np.abs(direction[:, 2]))
        one = (te * np.sum(electric * across, axis=1))[:, None] * across
        return one + (tm * np.sum(electric * within, axis=1))[:, None] * within * FLIP


# ------------------------------------------------------------------ antennas and room
@dataclass
class Antenna:
    """A place, the electric field's direction, and a Gaussian lobe that looks at the origin."""

    place: np.ndarray
    electric: np.ndarray
    width_deg: float = 30.0

    def gain(self, towards):
        """Return the share of the amplitude in directions."""
        off = np.degrees(np.arccos(np.clip(towards @ unit(-self.place), -1, 1)))
        return np.exp(-0.5 * np.log(2) * (2 * off / self.width_deg) ** 2)


@dataclass
class Wall:
    """An upright mirror at a distance in an azimuth; the sphere's waves lose all but `share` there."""

    distance: float
    azimuth_deg: float
    share: float

    @property
    def normal(self):
        """Outwards."""
        return np.array([np.cos(np.radians(self.azimuth_deg)), np.sin(np.radians(self.azimuth_deg)), 0.0])

    def image(self, place):
        """Return mirrored places."""
        return place - 2 * ((place @ self.normal) - self.distance)[..., None] * self.normal

    def flip(self, v):
        """Return mirrored directions."""
        return v - 2 * (v @ self.normal)[..., None] * self.normal


@dataclass
class Room:
    """Transmitter, receivers, floor (height of its surface, direction), walls, sphere, wave number."""

    k: float
    radius: float
    transmitter: Antenna
    receivers: list[Antenna]
    plate: Plate | None = None
    surface: float = 0.0
    normal: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    walls: list[Wall] = field(default_factory=list)
    exchange: bool = False
    point: bool = False

    def _frame(self):
        """Return the rotation in which the floor is level."""
        z = unit(self.normal)
        x = unit(np.cross([0.0, 1.0, 0.0], z))
        return np.stack([x, np.cross(z, x), z])

    def _ways(self, antenna, place, turn):
        """Return (length, direction of travel at the sphere if it sends, field there) of the ways to the sphere.

        All in the floor's frame. By reciprocity the same list serves a receiver, its directions reversed.
        """
        at, electric = turn @ antenna.place, turn @ antenna.electric
        seen = Antenna(at, electric, antenna.width_deg)
        ways = [(at, lambda v: v, lambda k, e: e)]
        if self.plate is not None:
            below = 2 * self.surface_z
            plate = self.plate

            ways.append(
                (at * FLIP + [0, 0, below], lambda v: v * FLIP, lambda k, e: plate.reflect(self.k, k * FLIP, e))
            )
        for wall in self.walls:
            turned = TurnedWall(wall, turn)
            ways.append((turned.image(at), turned.flip, lambda k, e, w=turned: -w.wall.share * w.flip(e)))
        result = []
        for image, back, after in ways:
            way = place - image
            length = np.linalg.norm(way, axis=1)
            direction = way / length[:, None]
            leaving = back(direction)
            sent = electric - (leaving @ electric)[:, None] * leaving
            result.append((length, direction, after(direction, sent) * seen.gain(leaving)[:, None]))
        return result

    def echo(self, position):
        """Return the complex signal of each receiver over exp(i K L) of the straight path, (receivers, n)."""
        turn = self._frame()
        self.surface_z = self.surface * self.normal[2]
        place = position @ turn.T
        height = place[:, 2] - self.surface_z if self.exchange and self.plate is not None else None
        share = -self.plate.coefficients(self.k, 1.0)[0] if height is not None else 1.0
        sphere = Sphere(self.radius, self.k, height, share)
        came = self._ways(self.transmitter, place, turn)
        straight = came[0][0]
        total_m = total_n = 0.0
        for length, direction, electric in came:
            weight = (np.exp(1j * self.k * (length - straight)) / length)[:, None]
            into = sphere.excited(direction, electric)
            total_m, total_n = total_m + weight * into[0], total_n + weight * into[1]
        out = sphere.answered(total_m, total_n)
        signals = []
        for receiver in self.receivers:
            ways = self._ways(receiver, place, turn)
            straight = ways[0][0]
            total = 0.0
            for length, direction, electric in ways:
                weight = np.exp(1j * self.k * (length - straight)) / length
                if self.point:
                    total = total + weight * sum(
                        np.exp(1j * self.k * (one[0] - came[0][0])) / one[0] for one in came[:1]
                    )
                else:
                    total = total + weight * np.sum(electric * sphere.sent(out, -direction), axis=1)
            signals.append(total)
        return np.array(signals)

    def lengths(self, position):
        """Return the straight path of each receiver, (receivers, n)."""
        first = np.linalg.norm(position - self.transmitter.place, axis=1)
        return np.array([first + np.linalg.norm(position - one.place, axis=1) for one in self.receivers])


@dataclass
class TurnedWall:
    """A wall in the floor's frame."""

    wall: Wall
    turn: np.ndarray

    def image(self, place):
        return self.turn @ self.wall.image(self.turn.T @ place)

    def flip(self, v):
        return self.wall.flip(v @ self.turn) @ self.turn.T


def strongest(field_vector, towards):
    """Return the direction across `towards` in which a complex field swings most."""
    real = np.real(np.outer(field_vector, field_vector.conj()))
    across = np.eye(3) - np.outer(towards, towards)
    return np.linalg.eigh(across @ real @ across)[1][:, -1]


# ------------------------------------------------------------------ the drop
@dataclass
class Flight:
    """One piece of the motion: from when to when, and where."""

    begin: float
    end: float
    place: object


@dataclass
class Motion:
    """Rest, flights and rest; impacts as (time, speed before, speed after) along the floor's normal."""

    pieces: list[Flight]
    impacts: list[tuple[float, float, float]]

    def at(self, time):
        """Return places (n, 3)."""
        result = np.empty((len(time), 3))
        edges = [piece.begin for piece in self.pieces[1:]]
        which = np.searchsorted(edges, time, side="right")
        for number, piece in enumerate(self.pieces):
            chosen = which == number
            if chosen.any():
                result[chosen] = piece.place(time[chosen])
        return result


def drag_per_mass(speed, diameter, density):
    """Return the air's deceleration over the velocity, 1/s: the curve of Clift and Gauvin."""
    reynolds = max(AIR_DENSITY * speed * diameter / AIR_VISCOSITY, 1e-9)
    cd = 24 / reynolds * (1 + 0.15 * reynolds**0.687) + 0.42 / (1 + 42500 * reynolds**-1.16)
    return 0.75 * AIR_DENSITY / density * cd * speed / diameter


def drop(release, velocity, start, end, touch, normal, gravity, diameter, density, bounce, air=1.0):
    """Return the motion of a sphere let go at `start`; `bounce(velocity, normal)` gives the velocity after an impact.

    touch
        A point of the plane that the centre is on when the sphere touches.
    air
        Share of the air's drag; 0 of none, its buoyancy stays.
    """
    ratio = AIR_DENSITY / density
    # buoyancy, and half of the air that the sphere pushes aside falls with it
    down = gravity * (1 - ratio) / (1 + 0.5 * ratio)

    def fall(_, state):
        v = state[3:]
        pull = -air * drag_per_mass(np.linalg.norm(v), diameter, density) / (1 + 0.5 * ratio) * v
        return np.concatenate([v, pull - [0, 0, down]])

    def over(_, state):
        return (state[:3] - touch) @ normal

    over.terminal, over.direction = True, -1
    hung = np.array(release)
    pieces = [Flight(0.0, start, lambda t, p=hung: np.broadcast_to(p, (len(t), 3)))]
    impacts, now, state = [], start, np.concatenate([release, velocity])
    while now < end:
        solved = solve_ivp(
            fall, (now, end), state, "DOP853", events=over, dense_output=True, rtol=1e-12, atol=1e-14, max_step=0.02
        )
        pieces.append(Flight(now, solved.t[-1], lambda t, s=solved.sol: s(t)[:3].T))
        if not solved.t_events[0].size:
            break
        now, state = solved.t_events[0][0], solved.y_events[0][0].copy()
        state[:3] -= over(0, state) * normal
        before = -state[3:] @ normal
        state[3:] = bounce(state[3:], normal)
        after = state[3:] @ normal
        impacts.append((now, before, after))
        if after < 0.04:
            lying = state[:3].copy()
            pieces.append(Flight(now, end, lambda t, p=lying: np.broadcast_to(p, (len(t), 3))))
            break
    return Motion(pieces, impacts)


# ------------------------------------------------------------------ the electronics
@dataclass
class Receiver:
    """A mixer: amplitude in V, phase, gain and angle of Q, offsets in V with what leaks into them."""

    amplitude: float
    phase: float
    gain: float
    quadrature: float
    offset: tuple[float, float]

    def volts(self, signal):
        """Return I and Q of a complex signal of one at the release."""
        turned = self.amplitude * signal * np.exp(1j * self.phase)
        i, q = turned.real, turned.imag
        return i + self.offset[0], self.gain * (
            q * np.cos(self.quadrature) + i * np.sin(self.quadrature)
        ) + self.offset[1]


@dataclass
class Echoes:
    """The complex signals of all receivers, of size one at the release.

    What changes slowly beside the straight path is computed every 0.25 mm of the way and drawn as a curve between.
    """

    room: Room
    motion: Motion

    def __post_init__(self):
        self.size = np.abs(self.room.echo(self.motion.at(np.zeros(1)))[:, 0])
        self.curves = []
        for piece in self.motion.pieces:
            fine = np.linspace(piece.begin, piece.end, 4001)
            way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(piece.place(fine), axis=0), axis=1))])
            if way[-1] < 1e-9:
                still = self.room.echo(piece.place(fine[:1]))
                self.curves.append(lambda t, still=still: np.repeat(still, len(t), axis=1))
                continue
            # along the way, but never far apart in time, where it hardly moves
            mixed = way / way[-1] + (fine - fine[0]) / (fine[-1] - fine[0])
            knots = np.interp(np.linspace(0, 2, 2 * int(way[-1] / 2.5e-4) + 16), mixed, fine)
            self.curves.append(CubicSpline(knots, self.room.echo(piece.place(knots)), axis=1))

    def at(self, time, number):
        """Return the signal of a receiver at times."""
        result = np.empty(len(time), complex)
        which = np.searchsorted([piece.begin for piece in self.motion.pieces[1:]], time, side="right")
        for piece, curve in enumerate(self.curves):
            chosen = which == piece
            if chosen.any():
                straight = self.room.lengths(self.motion.pieces[piece].place(time[chosen]))[number]
                slow = curve(time[chosen])[number]
                result[chosen] = slow * np.exp(1j * self.room.k * straight)
        return result / self.size[number]
