"""What a plate reflects, at every angle and in both polarisations: Fresnel's coefficients and Airy's sum (method 1).

Both coefficients count as of a perfect conductor's image, which is 1: R_TE = -r_s, R_TM = r_p (Born & Wolf, section
1.5.2, and 1.6.4 for the plate), time factor exp(-i w t). What a sphere and a plane that reflects send to and fro: the
sphere and its image as two coupled bodies (method 1).

Spherical waves about the sphere's centre, z along the plane's normal, time factor exp(-i w t): with X_lm = L Y_lm /
sqrt(l (l + 1)) the waves M = h_l(k r) X and N = curl M / k. The sphere multiplies what arrives by T = -(b_l, a_l) of
Mie's series, the plane returns what it scatters as waves of its image (P), and a translation by twice the height
expands these about the sphere again (A): c = T (a + R A P c). The sphere's own scattering is T a; the exchange is what
(1 - R T A P)^-1 T is more. Exact for a perfect conductor, R = 1, as plane waves at the sphere are (Peterson & Strom
1973, https://doi.org/10.1103/PhysRevD.8.3661). Of a plate that is known R A P has each direction's own R_TE and R_TM
(Egel et al. 2021, https://doi.org/10.1016/j.jqsrt.2021.107846).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.assumed import u_reflection
from radargui.model.radar import METAL, PLATES, Floor
from radargui.model.scattering import MieSphere
from radargui.model.setup import Setup

U_WAY = 0.1
"""Of what comes over a floor, as a share: an antenna that points some degrees beside the centre changes its size, a
plate 0.2 mm thicker than it is called its phase."""
_LEAST = 0.05  # |R| that ratios are taken to: some plates reflect nothing straight down
_ACROSS = 1e-12  # of sin^2: straight down both polarisations are one


@dataclass(frozen=True, slots=True)
class Plate:
    """A plane plate and what is below it; steel is `Plate(None)`.

    Attributes
    ----------
    index
        Refractive index against the air's, its imaginary part the loss; None of metal.
    thickness_m
        Of the plate.
    backing
        Refractive index of what is below it; None of metal.
    """

    index: complex | None
    thickness_m: float = 0.0
    backing: complex | None = 1.0

    @staticmethod
    def of(floor: Floor) -> Plate | None:
        """Return the plate of a setup's floor; None where it does not say of what it is."""
        if floor.material == "steel":
            return Plate(None)
        index = PLATES[floor.material] if floor.material is not None else floor.refractive_index
        if index is None or floor.thickness_m is None:
            return None
        below = floor.backing
        # air, where nothing is said
        backing = None if below == METAL else complex(below) if isinstance(below, float) else 1.0 + 0j
        return Plate(complex(index), floor.thickness_m, backing)

    def coefficients(self, cosine: FloatArray | ComplexArray, wavenumber: float) -> tuple[ComplexArray, ComplexArray]:
        """Return R_TE and R_TM at cosines of the angle of incidence, both of its shape; K in 1/m.

        Complex cosines, of evanescent waves, have no negative part.
        """
        square = 1.0 - cosine**2
        if self.index is None:
            one = np.ones(cosine.shape, complex)
            return one, one
        inside = np.asarray(np.sqrt(self.index**2 - square + 0j))
        s_top, p_top = _fresnel(1.0, np.asarray(cosine + 0j), self.index, inside)
        if self.backing is None:
            s_low, p_low = -np.ones(cosine.shape, complex), np.ones(cosine.shape, complex)
        else:
            below = np.asarray(np.sqrt(self.backing**2 - square + 0j))
            s_low, p_low = _fresnel(self.index, inside, self.backing, below)
        turn = np.exp(2j * wavenumber * self.thickness_m * inside)
        r_s, r_p = ((top + low * turn) / (1.0 + top * low * turn) for top, low in ((s_top, s_low), (p_top, p_low)))
        return -r_s, r_p

    def straight_down(self, wavenumber: float) -> complex:
        """Return R straight down, 0.05 at least: what is counted against it has to be there."""
        found = complex(self.coefficients(np.ones(1), wavenumber)[0][0])
        return found * max(1.0, _LEAST / max(abs(found), 1e-9))

    def parts(
        self, direction: FloatArray, normal: FloatArray, field: FloatArray, wavenumber: float
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return what fields are reflected as, over R straight down: a share of the image's field, and of the normal.

        The image of a perfect conductor has the mirrored field e, across the way k. What a plate leaves of it is R_TE e
        + (R_TM - R_TE) p (p.e), p along n - k (k.n), and what is along k radiates nothing: R_TE e + v n.

        Parameters
        ----------
        direction
            Unit vectors k of the ways beyond the plate, shape (..., 3, n).
        normal
            Of the plate, shape (3,).
        field
            e, shape (..., n_fields, 3).
        wavenumber
            1/m.

        Returns
        -------
        tuple
            R_TE, shape (..., n), and v, shape (..., n_fields, n).
        """
        along = np.einsum("i,...in->...n", normal, direction)
        r_te, r_tm = self.coefficients(np.abs(along), wavenumber)
        across = (field @ normal)[..., None] - along[..., None, :] * (field @ direction)
        share = (r_tm - r_te) / np.maximum(1.0 - along**2, _ACROSS)
        straight = self.straight_down(wavenumber)
        return np.asarray(r_te / straight), np.asarray(share[..., None, :] * across / straight)


@dataclass(frozen=True, slots=True)
class StatedSurface:
    """What the setup says that a floor reflects.

    Attributes
    ----------
    reflection, u_reflection
        |R| straight down.
    plate
        Of what it is: R at every angle, and its phase at the surface; None where only |R| is known.
    touch_m
        How high over its surface the centre of the sphere is that touches it.
    """

    reflection: float
    u_reflection: float
    plate: Plate | None = None
    touch_m: float = 0.0

    @staticmethod
    def of(setup: Setup) -> StatedSurface | None:
        """Return what a setup says; None where it leaves it open."""
        floor = setup.floor
        if floor.reflection is not None:
            return StatedSurface(floor.reflection, u_reflection(floor))
        plate = Plate.of(floor)
        if plate is None:
            return None
        straight = plate.straight_down(2.0 * np.pi / setup.radar.wavelength_m)
        return StatedSurface(abs(straight), u_reflection(floor), plate, 0.5 * setup.tracer.diameter_m)

    def expected(self, cosine: FloatArray, wavenumber: float, *, is_point: bool) -> tuple[ComplexArray, FloatArray]:
        """Return R as each antenna counts it, and its uncertainty as a share, shape (n,) both.

        Parameters
        ----------
        cosine
            Of the angle of incidence, shape (n,).
        wavenumber
            In 1/m.
        is_point
            Whether the sphere counts as a point: R of both polarisations is then what it might be.
        """
        u = np.full(cosine.size, self.u_reflection / self.reflection)
        if self.plate is None:
            return np.full(cosine.size, self.reflection, complex), np.hypot(u, U_WAY)
        expected = np.full(cosine.size, self.plate.straight_down(wavenumber))
        if is_point:
            electric, magnetic = self.plate.coefficients(cosine, wavenumber)
            middle, half = 0.5 * (electric + magnetic), 0.5 * np.abs(electric - magnetic)
            u = np.hypot(u, half / np.abs(expected))
            expected = np.where(np.abs(middle) > self.u_reflection, middle, expected)
        return expected, np.hypot(u, U_WAY)


def _fresnel(n_1: complex, q_1: ComplexArray, n_2: complex, q_2: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return r_s and r_p of a surface between two media, each its index n and q, that times the cosine in it."""
    r_s = (q_1 - q_2) / (q_1 + q_2)
    r_p = (n_2**2 * q_1 - n_1**2 * q_2) / (n_2**2 * q_1 + n_1**2 * q_2)
    return np.asarray(r_s), np.asarray(r_p)


@dataclass(frozen=True, slots=True)
class Exchanged:
    """What the exchange adds to `scattered_signals`, and how that changes; no unit.

    Attributes
    ----------
    signal
        For every way in and out and pair of fields, shape (n_in, n_out, n_sent, n_got, n_samples).
    by_height, by_log_reflection
        Its slopes by the height (1/m) and by ln R, same shape.
    """

    signal: ComplexArray
    by_height: ComplexArray
    by_log_reflection: ComplexArray


_STEP = 1e-4  # of K h: differences are off by as much of what A is curved by
_NODES = -2.7, 3.7, 60  # of w where exp(w - exp(-w)) is i times the cosine less one: h_p to 1e-5 at 2 K h of 1 to 400


def exchanged_signals(
    sphere: MieSphere,
    height_m: FloatArray,
    reflection: complex,
    normal: FloatArray,
    incident: FloatArray,
    transmitted: FloatArray,
    leaving: FloatArray,
    received: FloatArray,
    plate: Plate | None = None,
) -> Exchanged:
    """Return what the exchange adds to `scattered_signals`, for every way in and every way out.

    Parameters
    ----------
    sphere
        The tracer.
    height_m
        Of its centre over the plane, shape (n_samples,); a plane that cuts it counts as if they touched.
    reflection
        R of the plane straight down, 1 of a perfect conductor: what its image scatters counts so much.
    normal
        Of the plane towards the sphere, shape (3,).
    incident, leaving
        Unit vectors of the ways in and out, shapes (n_in, 3, n_samples) and (n_out, 3, n_samples).
    transmitted, received
        Fields sent and answered to, shapes (n_in, n_sent, 3) and (n_out, n_got, 3).
    plate
        Of what the plane is: how R differs from `reflection` with angle and polarisation; None: not at all.
    """
    orders = n_orders(sphere.size)
    scaled, phase = _heights(sphere, height_m)
    electric, magnetic = sphere.electric[:orders], sphere.magnetic[:orders]
    turn = _frame(normal)
    arriving = _Harmonics(turn @ incident, transmitted @ turn.T, orders)
    answered = _Harmonics(turn @ leaving, received @ turn.T, orders)
    near = 2.0 * np.stack([scaled, scaled + _STEP])
    wavenumber = 2.0 * np.pi / sphere.wavelength_m
    layers = None if plate is None or plate.index is None else plate
    radial = _hankel(2 * orders, near) if layers is None else _over_plate(2 * orders, near, layers, wavenumber)
    n_sent, n_got = int(np.prod(arriving.shape)), int(np.prod(answered.shape))
    out = np.zeros((height_m.size, n_got, 3, n_sent), complex)
    for m in range(orders + 1):
        order = np.arange(max(m, 1), orders + 1)
        # T^(1/2) on both sides: by themselves high orders are tiny in T and huge in A
        root = np.sqrt(-np.concatenate([magnetic[order - 1], electric[order - 1]]))
        parity, turns = (-1.0) ** (order + m), np.tile(1j**order, 2)
        image = _translation(radial, near, m, orders) if layers is None else _returned(radial, m, orders)
        returned, higher = image * (
            (reflection * phase)[:, None, None] * root[:, None] * np.concatenate([parity, -parity]) * root
        )
        # both parities, real and imaginary parts, side by side: neither becomes the other
        sent = (turns * root)[:, None] * np.concatenate([*arriving.of(m)], axis=-1)
        again = np.linalg.inv(np.eye(root.size) - returned)
        # of u = (1 - B)^-1 a: B u is what comes back, (1 - B)^-1 B u and (1 - B)^-1 dB u its changes with ln B and B
        whole = again @ sent
        change = (higher - returned) @ whole * (wavenumber / _STEP)
        waves = np.stack([whole - sent, again @ change, again @ whole - whole], axis=-2)
        weight = -4.0 * np.pi * (1.0 if m == 0 else 2.0) * np.conj(turns) * root
        for got, part in zip(answered.of(m), np.split(waves, 2, axis=-1), strict=True):
            rows = part.reshape(*part.shape[:2], -1)
            out += ((weight[:, None] * got).swapaxes(-1, -2) @ rows).reshape(out.shape)
    shape = (height_m.size, *answered.shape, 3, *arriving.shape)
    parts = np.ascontiguousarray(out.reshape(shape).transpose(3, 4, 1, 5, 2, 0))
    return Exchanged(parts[0], parts[1], parts[2])


def n_orders(size: float) -> int:
    """Return how many orders of spherical waves go to and fro between a sphere of size x = K a and its image."""
    return int(size) + 3


def changes_faster(gap_m: FloatArray, reflection: float, radius_m: float) -> FloatArray:
    """Return how many times faster than its direct wave turns an echo over a floor changes, at most, shape (n,).

    What goes over the floor in and out, |R|^2 of it, turns the other way, and near it what went to and fro some times
    comes on top. Bins of 1/12 turn of the direct wave, as if it turned so much faster, keep the mean of two
    nodes right where otherwise 0.5 % of the direct wave would be missing at R = 0.93, near the floor 3 to 10 %.

    Parameters
    ----------
    gap_m
        Between sphere and floor, shape (n,).
    reflection
        |R|.
    radius_m
        Of the sphere.
    """
    near = np.exp(-np.maximum(gap_m, 0.0) / max(radius_m, 1e-6))
    return np.asarray(1.0 + 2.0 * min(reflection, 1.0) ** 2 * (1.0 + 3.0 * near))


def _heights(sphere: MieSphere, height_m: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """Return K h over a plane that is nowhere above the sphere, (n,), and the phase of a longer way.

    Where the plane, not found well yet, cuts the sphere, it lies as much lower as lets them touch at the lowest place.
    """
    scaled = 2.0 * np.pi / sphere.wavelength_m * height_m
    lower = max(sphere.size - float(scaled.min()), 0.0)
    return scaled + lower, np.full(scaled.shape, np.exp(-2j * lower))


def _frame(normal: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) into axes of which the last is a unit vector (3,)."""
    first = np.cross(np.eye(3)[int(np.argmin(np.abs(normal)))], normal)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first), normal])


class _Harmonics:
    """X_lm . e and i k x X_lm . e of directions k and fields e: what plane waves and far fields are made of.

    Of -m they are the conjugates of those of m but for signs that cancel in a product of two, so that both orders
    together leave products of real parts and products of imaginary parts.
    """

    def __init__(self, direction: FloatArray, field: FloatArray, orders: int) -> None:
        self.shape, self.orders = field.shape[:2], orders
        self._scalar = _spherical_harmonics(direction, orders)
        along = np.broadcast_to(field[..., None], (*self.shape, *direction.shape[1:]))
        # Z . e = i (k x X) . e = i X . (e x k)
        across = np.cross(along, direction[:, None], axis=2)
        self._vectors = np.stack([along, across])

    def of(self, m: int) -> FloatArray:
        """Return their real and imaginary parts of the orders max(m, 1) and up.

        M before N, shape (2 parities, n_samples, 2 n_orders, n_directions n_fields).
        """
        first, y = max(m, 1), self._scalar
        order = np.arange(first, self.orders + 1)
        size = np.sqrt(order * (order + 1.0))[:, None, None, None]
        # L . v = v_z L_z + (v_x - i v_y) L_+ / 2 + (v_x + i v_y) L_- / 2 of the operators that raise and lower m
        raised = np.sqrt(order * (order + 1.0) - m * (m + 1.0))[:, None, None, None] / size
        lowered = np.sqrt(order * (order + 1.0) - m * (m - 1.0))[:, None, None, None] / size
        below = -np.conj(y[first:, 1]) if m == 0 else y[first:, m - 1]
        x, up, down = y[first:, m, :, None] * m / size, raised * y[first:, m + 1, :, None], lowered * below[:, :, None]
        parts = [
            v[..., 2, :] * x
            + 0.5 * ((v[..., 0, :] - 1j * v[..., 1, :]) * up + (v[..., 0, :] + 1j * v[..., 1, :]) * down)
            for v in self._vectors
        ]
        both = np.concatenate([parts[0], 1j * parts[1]])
        both = both.transpose(3, 0, 1, 2).reshape(both.shape[-1], both.shape[0], -1)
        return np.stack([both.real, both.imag])


def _spherical_harmonics(direction: FloatArray, orders: int) -> ComplexArray:
    """Return orthonormal Y_lm, shape (orders + 1, orders + 2, n, n_samples), of unit vectors (n, 3, n_samples), m >= 0.

    (x + i y)^m times a polynomial in z, upwards in l (Condon and Shortley's phase).
    """
    x, y, z = np.moveaxis(direction, 1, 0)
    out = np.zeros((orders + 1, orders + 2, *z.shape), complex)
    first = np.full(z.shape, np.sqrt(0.25 / np.pi), complex)
    for m in range(orders + 1):
        if m:
            first = -np.sqrt(1.0 + 0.5 / m) * (x + 1j * y) * first
        out[m, m] = first
        for order in range(m + 1, orders + 1):
            out[order, m] = np.sqrt((4.0 * order**2 - 1.0) / (order**2 - m**2)) * (
                z * out[order - 1, m] - (_step_down(order - 1, m) * out[order - 2, m] if order > m + 1 else 0.0)
            )
    return out


def _step_down(order: int, m: int) -> float:
    return float(np.sqrt((order**2 - m**2) / (4.0 * order**2 - 1.0)))


def _hankel(highest: int, x: FloatArray) -> ComplexArray:
    """Return h_p(x), p = 0 ... highest, shape (..., highest + 1), upwards: where it matters y_p is what grows."""
    wave = np.exp(1j * x) / x
    out = [-1j * wave, -(1.0 + 1j / x) * wave]
    for p in range(1, highest):
        out.append((2 * p + 1) / x * out[p] - out[p - 1])
    return np.stack(out, axis=-1)


def _translation(hankel: ComplexArray, apart: FloatArray, m: int, orders: int) -> ComplexArray:
    """Return the coefficients (..., 2 k, 2 k) of outgoing waves, from K d (...) below, as regular ones; l >= max(m, 1).

    A wave M_l is the sum of plane waves with X_l(k), and its source's place turns each by exp(i K d cos):

        M_l = sum over v of i^(v - l) (<X_v, X_l exp> M_v + <Z_v, X_l exp> N_v),   Z = i k x X.

    With exp(i K d cos) = sum i^p (2 p + 1) j_p P_p, h_p for j_p of an outgoing wave, the integrals are those of Y_v Y_l
    P_p times (v (v + 1) + l (l + 1) - p (p + 1)) / 2 s_v s_l, and times i m K d / s_v s_l.
    """
    same, other = _integrals(m, orders)
    k = same.shape[0]
    out = np.empty((*apart.shape, 2 * k, 2 * k), complex)
    out[..., :k, :k] = out[..., k:, k:] = (hankel @ same.reshape(k * k, -1).T).reshape(*apart.shape, k, k)
    other_way = (hankel @ other.reshape(k * k, -1).T).reshape(*apart.shape, k, k) * apart[..., None, None]
    out[..., :k, k:] = out[..., k:, :k] = other_way
    return out


def _over_plate(highest: int, x: FloatArray, plate: Plate, wavenumber: float) -> ComplexArray:
    """Return what stands for h_p(x) over a plate, of R_TE and of R_TM, shape (..., 2, highest + 1); x is 2 K h.

    h_p(x) is (-i)^p times the integral of P_p(c) exp(i x c), c the cosines of the plane waves down to evanescent ones,
    from i times infinity to one: each of them gets R(c) over R straight down. Straight up from one, c = 1 + i t,
    nothing turns, and poles of a plate, its guided waves, lie beyond.
    """
    w = np.linspace(*_NODES)
    t = np.exp(w - np.exp(-w))
    c = 1.0 + 1j * t
    weight = -1j * t * (1.0 + np.exp(-w)) * (w[1] - w[0])
    reflected = np.array(plate.coefficients(c, wavenumber)) / plate.straight_down(wavenumber)
    turn = (-1j) ** (np.arange(highest + 1) % 4)
    of_node = (weight * reflected).T[..., None] * (np.polynomial.legendre.legvander(c, highest) * turn)[:, None]
    waves = np.exp(1j * x[..., None] * c) @ of_node.reshape(c.size, -1)
    return np.asarray(waves.reshape(*x.shape, 2, highest + 1))


def _returned(radial: ComplexArray, m: int, orders: int) -> ComplexArray:
    """Return what a plate sends back of outgoing waves, as `_translation` does of their image; l >= max(m, 1).

    With pi = m P / sin and tau = dP / d angle over sqrt(l (l + 1)) a wave M has pi along the plane of incidence, which
    gets R_TM, and tau across it, which gets R_TE; N the other way round.
    """
    out = [
        np.concatenate([radial[..., 0, :], radial[..., 1, :]], axis=-1) @ part.reshape(-1, part.shape[-1]).T
        for part in _angular_integrals(m, orders)
    ]
    k = orders + 1 - max(m, 1)
    blocks = np.stack(out, axis=-2).reshape(*radial.shape[:-2], 2, 2, k, k)
    return np.asarray(np.moveaxis(blocks, -2, -3).reshape(*radial.shape[:-2], 2 * k, 2 * k))


@lru_cache(maxsize=64)
def _angular_integrals(m: int, orders: int) -> tuple[ComplexArray, ...]:
    """Return what the waves of `_over_plate` are multiplied with, of M as M, N as M, M as N and N as N.

    Legendre series of the products of pi and tau, polynomials in the cosine: shape (k, k, 2 (2 orders + 1)), those of
    R_TE first.
    """
    node, weight = np.polynomial.legendre.leggauss(2 * orders + 2)
    sine = np.sqrt(1.0 - node**2)
    harmonic = _spherical_harmonics(np.stack([sine, 0.0 * node, node])[None], orders)[:, m, 0].real
    order = np.arange(max(m, 1), orders + 1)
    size = np.sqrt(order * (order + 1.0))[:, None]
    pi = m * harmonic[order] / sine / size
    down = np.sqrt((2.0 * order + 1.0) / (2.0 * order - 1.0) * (order**2 - m**2))[:, None] * harmonic[order - 1]
    tau = (order[:, None] * node * harmonic[order] - down) / sine / size
    p = np.arange(2 * orders + 1)
    series = np.polynomial.legendre.legvander(node, p[-1]) * weight[:, None] * (p + 0.5)
    # radial waves have (-i)^p
    turn = 4.0 * np.pi * 1j ** ((order[:, None] - order)[..., None] % 4) * 1j ** (p % 4)
    products = {
        (one, two): turn * np.einsum("vg,lg,gp->vlp", one_values, two_values, series)
        for one, one_values in (("pi", pi), ("tau", tau))
        for two, two_values in (("pi", pi), ("tau", tau))
    }
    parts = (
        ("tau", "tau", "pi", "pi"),
        ("tau", "pi", "pi", "tau"),
        ("pi", "tau", "tau", "pi"),
        ("pi", "pi", "tau", "tau"),
    )
    return tuple(np.concatenate([products[a, b], products[c, d]], axis=-1) for a, b, c, d in parts)


@lru_cache(maxsize=64)
def _integrals(m: int, orders: int) -> tuple[ComplexArray, ComplexArray]:
    """Return what h_p is multiplied with in `_translation`, for v, l >= max(m, 1) and p, shape (k, k, 2 orders + 1)."""
    node, weight = np.polynomial.legendre.leggauss(2 * orders + 2)
    across = np.stack([np.sqrt(1.0 - node**2), 0.0 * node, node])
    harmonic = _spherical_harmonics(across[None], orders)[max(m, 1) :, m, 0].real
    p = np.arange(2 * orders + 1)
    polynomial = np.polynomial.legendre.legvander(node, 2 * orders)
    integral = 2.0 * np.pi * np.einsum("vg,lg,gp,g->vlp", harmonic, harmonic, polynomial, weight)
    order = np.arange(max(m, 1), orders + 1)
    v, of = order[:, None, None], order[:, None]
    # others are zero, and what rounding leaves would meet h_p beyond all bounds
    there = (p >= abs(v - of)) & (p <= v + of) & ((v + of + p) % 2 == 0)
    size = np.sqrt(v * (v + 1.0) * of * (of + 1.0))
    integral = np.where(there, integral * (2.0 * p + 1.0) / size, 0.0) * 1j ** ((v - of + p) % 4)
    return 0.5 * (v * (v + 1.0) + of * (of + 1.0) - p * (p + 1.0)) * integral, 1j * m * integral
