"""Compute what a sphere scatters (Mie series), and what an antenna of some polarisation receives of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev, legendre

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.radar import Radar, Receiver, Tracer, Transmitter


@dataclass(frozen=True, slots=True, eq=False)
class MieSphere:
    """The scattering amplitudes of one sphere at one wavelength, as polynomials in the cosine mu of the angle.

    S1 and S2 (Bohren & Huffman 1983, eq. 4.74) are S1 = U + mu V and S2 = V + mu U. With pi_n = P_n', tau_n = mu pi_n -
    (1 - mu^2) pi_n' and w_n = (2n + 1) / (n (n + 1)) the parts U = (S1 - mu S2) / (1 - mu^2) and V = (S2 - mu S1) /
    (1 - mu^2) have no pole:

        U = sum w_n (a_n (pi_n + mu pi_n') - b_n pi_n'),   V = sum w_n (b_n (pi_n + mu pi_n') - a_n pi_n').

    Attributes
    ----------
    radius_m, wavelength_m
        Of the sphere and of the wave.
    electric, magnetic
        a_n and b_n, shape (n_max,).
    series
        Chebyshev coefficients of Re U, Im U, Re V, Im V, shape (n_max, 4).
    """

    radius_m: float
    wavelength_m: float
    electric: ComplexArray
    magnetic: ComplexArray
    series: FloatArray

    @property
    def size(self) -> float:
        """Size parameter x = 2 pi radius / wavelength."""
        return 2.0 * np.pi * self.radius_m / self.wavelength_m

    def parts(self, cosine: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return U and V; no unit.

        Parameters
        ----------
        cosine
            Of the angle between the incident and the scattered direction, any shape.
        """
        # every angle with all orders at once: a product of matrices
        values = chebyshev.chebvander(cosine.ravel(), self.series.shape[0] - 1) @ self.series
        u, v = values.view(np.complex128).T
        return u.reshape(cosine.shape), v.reshape(cosine.shape)


@lru_cache(maxsize=32)
def mie_sphere(radius_m: float, wavelength_m: float, index: float | None = None) -> MieSphere:
    """Return the sphere of this radius at a wavelength, of a refractive index against the air's; None: of metal."""
    electric, magnetic = scattering_coefficients(2.0 * np.pi * radius_m / wavelength_m, index)
    return MieSphere(radius_m, wavelength_m, electric, magnetic, _series(electric, magnetic))


def tracer_sphere(tracer: Tracer, radar: Radar) -> MieSphere:
    """Return the sphere of a setup."""
    index = None if tracer.index is None else tracer.index / radar.index
    return mie_sphere(0.5 * tracer.diameter_m, radar.wavelength_m, index)


def scattering_coefficients(size: float, index: float | None = None) -> tuple[ComplexArray, ComplexArray]:
    """Return a_n and b_n, shape (n_max,), with psi = x j_n, xi = x h_n (Bohren & Huffman, eq. 4.56 and 4.57).

    a_n = (m psi(mx) psi'(x) - psi(x) psi'(mx)) / (m psi(mx) xi'(x) - xi(x) psi'(mx)), b_n the same with m at the other
    product. The perfect conductor is the limit of an infinite refractive index, psi' / xi' and psi / xi. Orders up to
    x + 4 x^(1/3) + 3 (Wiscombe 1980). The time factor is exp(-i w t), so that a path L gives exp(+i K L).

    Parameters
    ----------
    size
        x = 2 pi radius / wavelength.
    index
        m, refractive index against that outside; None: a perfect conductor.
    """
    order = np.arange(1, int(size + 4.0 * np.cbrt(size) + 3.0) + 1)
    regular, irregular = _spherical_bessel(order.size, size)
    # (x f_n)' = x f_(n-1) - n f_n; the field along the metal vanishes: a_n by the slopes, b_n by the values
    regular_slope = size * regular[:-1] - order * regular[1:]
    irregular_slope = size * irregular[:-1] - order * irregular[1:]
    regular, irregular = regular[1:], irregular[1:]
    slope, value = regular_slope + 1j * irregular_slope, regular + 1j * irregular
    if index is None:
        return np.asarray(regular_slope / slope), np.asarray(regular / value)
    inner, _ = _spherical_bessel(order.size, index * size)
    inner_slope, inner = index * size * inner[:-1] - order * inner[1:], inner[1:]

    def ratio(of_slopes: float) -> ComplexArray:
        above = of_slopes * inner * regular_slope - regular * inner_slope
        return np.asarray(above / (of_slopes * inner * slope - value * inner_slope))

    return ratio(index**2), ratio(1.0)


def _spherical_bessel(most: int, x: float) -> tuple[FloatArray, FloatArray]:
    """Return j_n(x) and y_n(x), n = 0 ... `most`, by f_(n-1) + f_(n+1) = (2n + 1) f_n / x.

    Downwards j_n is what grows, upwards y_n is (Abramowitz & Stegun, 10.5): each is found the way it grows.
    """
    # by hand: loading `scipy.special` costs 0.1 s, a tenth of processing a run of 10 s (decision 26)
    irregular = [-np.cos(x) / x, -np.cos(x) / x**2 - np.sin(x) / x]
    for n in range(1, most):
        irregular.append((2 * n + 1) / x * irregular[n] - irregular[n - 1])
    # so far above that what it begins with does not matter
    above, regular = most + int(x) + 20, [0.0, 1e-300]
    for n in range(above, 0, -1):
        regular.append((2 * n + 1) / x * regular[-1] - regular[-2])
    down = np.array(regular[: -most - 2 : -1])
    # j_0 and j_1 have no common zero
    first = np.array([np.sin(x) / x, np.sin(x) / x**2 - np.cos(x) / x])
    which = int(np.argmax(np.abs(first)))
    return down * (first[which] / down[which]), np.array(irregular[: most + 1])


def _series(electric: ComplexArray, magnetic: ComplexArray) -> FloatArray:
    """Return the Chebyshev coefficients of `MieSphere.series`."""
    order = np.arange(1, electric.size + 1)
    weight = (2.0 * order + 1.0) / (order * (order + 1.0))
    # sum w_n a_n P_n, whose slope and bend are those of pi_n and pi_n'; the leading 0 is the order n = 0
    a, b = (np.concatenate(([0.0], weight * one)) for one in (electric, magnetic))
    nodes = chebyshev.chebpts1(order.size)
    vander, columns = chebyshev.chebvander(nodes, order.size - 1), []
    for one, other in ((a, b), (b, a)):
        bend, minus = (legendre.legder(part, 2) if part.size > 2 else np.zeros(1) for part in (one, other))
        part = legendre.legsub(legendre.legadd(legendre.legder(one), legendre.legmulx(bend)), minus)
        # the values, not the powers, go from one series to the other: exact, and well conditioned in every order
        columns.append(np.linalg.solve(vander, legendre.legval(nodes, part)))
    return np.ascontiguousarray(np.stack(columns, axis=1)).view(np.float64)


def scattered_field(
    sphere: MieSphere,
    position_m: FloatArray,
    transmitter_m: FloatArray,
    transmitted: FloatArray,
    receiver_m: FloatArray,
) -> ComplexArray:
    """Return the direction and strength of the field at a receiver, without the distances and the phase of the path.

    E = S2 (par_i . e_tx) par_s + S1 (perp . e_tx) perp, with perp = unit(k_i x k_s) and par = k x perp. Multiplied out,
    with i, s the ways in and out and U, V of `MieSphere`, no scattering plane is left, nor its lack where the
    way goes straight on:

        E = S1 e - i (U i.e + V s.e) - s U (s.e - mu i.e)

    Parameters
    ----------
    sphere
        The tracer.
    position_m
        Its centre, shape (3, n_samples).
    transmitter_m, receiver_m
        Places of the antennas or of their images, shape (3,).
    transmitted
        Unit vectors of the transmitted field, shape (..., 3).

    Returns
    -------
    ComplexArray
        No unit, shape (..., 3, n_samples).
    """
    incident = unit_vectors(position_m - transmitter_m[:, None])
    leaving = unit_vectors(receiver_m[:, None] - position_m)
    # three antennas that answer to the axes get the components
    got = scattered_signals(sphere, incident, transmitted.reshape(-1, 3), leaving, np.eye(3))
    return got.reshape(*transmitted.shape, -1)


def scattered_signals(
    sphere: MieSphere, incident: FloatArray, transmitted: FloatArray, leaving: FloatArray, received: FloatArray
) -> ComplexArray:
    """Return what antennas get of the fields of `scattered_field`, for every pair of directions at once.

    Parameters
    ----------
    sphere
        The tracer.
    incident, leaving
        Unit vectors of the ways in and out, shape (..., 3, n_samples).
    transmitted, received
        Unit vectors of the fields sent, (..., n_sent, 3), and of those answered to, (..., n_got, 3).

    Returns
    -------
    ComplexArray
        No unit, shape (..., n_sent, n_got, n_samples); leading axes are broadcast.
    """
    cosine = (incident * leaving).sum(axis=-2)
    u, v = (part[..., None, :] for part in sphere.parts(cosine))
    cosine = cosine[..., None, :]
    sent_in, sent_out = transmitted @ incident, transmitted @ leaving
    got_in, got_out = received @ incident, received @ leaving
    by_in = u * sent_in + v * sent_out
    by_out = u * (sent_out - cosine * sent_in)
    straight = (transmitted @ np.swapaxes(received, -1, -2))[..., None] * (u + cosine * v)[..., None, :]
    through = by_in[..., :, None, :] * got_in[..., None, :, :] + by_out[..., :, None, :] * got_out[..., None, :, :]
    return np.asarray(straight - through)


def unit_vectors(vector: FloatArray) -> FloatArray:
    """Return vectors (..., 3, n) over their lengths."""
    return np.asarray(vector / np.sqrt((vector * vector).sum(axis=-2, keepdims=True)))


_ON_AXIS = 1e-9  # of a unit vector: nearer to the z axis than this the horizontal direction is the azimuth's


def transmitted_direction(polarization_deg: float) -> FloatArray:
    """Return the transmitter's field direction, counted from the x axis towards the y axis; shape (3,)."""
    angle = np.radians(polarization_deg)
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def transverse_axes(direction: FloatArray, azimuth_deg: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Return h = unit(z x u) and v = u x h, between which a receiver's polarisation angle is counted.

    Parameters
    ----------
    direction
        Unit vector u from the centre to the antenna, shape (3,).
    azimuth_deg
        Tells h = (-sin azimuth, cos azimuth, 0) where u is the z axis itself.
    """
    horizontal = np.array([-direction[1], direction[0], 0.0])
    length = float(np.hypot(horizontal[0], horizontal[1]))
    if length < _ON_AXIS:
        azimuth = np.radians(azimuth_deg)
        horizontal, length = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0]), 1.0
    (x, y, z), (h_x, h_y, _) = direction, horizontal / length
    # u x h written out: `np.cross` of three numbers takes ten times as long
    return np.array([h_x, h_y, 0.0]), np.array([-z * h_y, z * h_x, x * h_y - y * h_x])


def received_direction(polarization_deg: float, horizontal: FloatArray, vertical: FloatArray) -> FloatArray:
    """Return cos(p) h + sin(p) v, the field direction to which a receiver answers; shape (3,)."""
    angle = np.radians(polarization_deg)
    return np.asarray(np.cos(angle) * horizontal + np.sin(angle) * vertical)


def strongest_polarization_deg(field: ComplexArray, horizontal: FloatArray, vertical: FloatArray) -> float:
    """Return the angle, 0 to 180 degrees, at which a receiver gets most of a field.

    |E_h cos p + E_v sin p|^2 is largest at p = atan2(2 Re(E_h conj E_v), |E_h|^2 - |E_v|^2) / 2.

    Parameters
    ----------
    field
        Complex field vector, shape (3,).
    horizontal, vertical
        From `transverse_axes`.
    """
    along, across = complex(field @ horizontal), complex(field @ vertical)
    # of the two extremes of the ellipse of the field the longer one: atan2, not atan
    double = np.arctan2(2.0 * (along * across.conjugate()).real, abs(along) ** 2 - abs(across) ** 2)
    return float(np.degrees(double) / 2.0 % 180.0)


MIN_SHARE = 0.05
"""Of the strongest signal from the centre: a receiver that gets less is turned across the field."""


@dataclass(frozen=True, slots=True)
class ReceivedField:
    """What one receiver gets of the field that the sphere in the centre scatters to it.

    Attributes
    ----------
    horizontal, vertical
        h and v, between which the polarisation counts, shape (3,).
    angle_deg, strongest_deg
        The receiver's polarisation, and the one that gets the strongest signal.
    share
        Of the strongest signal, 0 to 1.
    """

    horizontal: FloatArray
    vertical: FloatArray
    angle_deg: float
    strongest_deg: float
    share: float


def received_fields(
    radar: Radar, transmitter: Transmitter, receivers: Sequence[Receiver], tracer: Tracer, polarization_deg: float
) -> tuple[ReceivedField, ...]:
    """Return what each receiver gets of the field of a transmitter polarised along `polarization_deg`."""
    # not small against the wave: how it turns the field on its way to a receiver depends on its size (Mie)
    sphere = tracer_sphere(tracer, radar)
    sent, place = transmitted_direction(polarization_deg), np.array(transmitter.place_m)
    out = []
    for receiver in receivers:
        tilt, azimuth = np.radians([receiver.tilt_deg, receiver.azimuth_deg])
        u = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
        h, v = transverse_axes(u, receiver.azimuth_deg)
        field = scattered_field(sphere, np.zeros((3, 1)), place, sent, receiver.reach_m * u)[:, 0]
        best = strongest_polarization_deg(field, h, v)
        # left out: whoever set it up turned it for the strongest signal
        own = best if receiver.polarization_deg is None else receiver.polarization_deg
        got, most = (abs(received_direction(angle, h, v) @ field) for angle in (own, best))
        out.append(ReceivedField(h, v, own, best, float(got / most) if most else 0.0))
    return tuple(out)
