"""Scattering by the tracer: a conducting sphere is a body, not a point (Mie theory)."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.special import spherical_jn, spherical_yn

from radargui.model.arrays import ComplexArray, FloatArray

_PARALLEL = 1e-12  # square of the sine between two ways below which no scattering plane is defined


@dataclass(frozen=True, slots=True, eq=False)
class ConductingSphere:
    """The scattering amplitudes of one sphere at one wavelength, as polynomials in the cosine of the angle.

    With pi_n = P_n' and tau_n = n (n + 1) P_n - mu P_n' (Legendre's equation), the sums S1, S2 of Bohren & Huffman
    (1983, eq. 4.74) are three Legendre series, made once: any number of angles then costs a Clenshaw sum each.

    Attributes
    ----------
    size
        x = 2 pi radius / wavelength.
    electric, magnetic
        a_n and b_n, shape (n_max,); time factor exp(-i w t), so that a path L gives exp(+i K L).
    """

    size: float
    electric: ComplexArray
    magnetic: ComplexArray

    def amplitudes(self, cosine: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return S1 (field across the scattering plane) and S2 (in the plane); no unit.

        Parameters
        ----------
        cosine
            Of the angle between the incident and the scattered direction, any shape.
        """
        across = _amplitude(self.electric, self.magnetic, cosine)
        return across, _amplitude(self.magnetic, self.electric, cosine)

    def extinction(self) -> float:
        """Return the extinction efficiency (2 / x^2) sum (2n + 1) Re(a_n + b_n) (Bohren & Huffman, eq. 4.62)."""
        return float(2.0 / self.size**2 * (_weight(self.electric.size) @ (self.electric + self.magnetic)).real)


def conducting_sphere(radius_m: float, wavelength_m: float) -> ConductingSphere:
    """Return the sphere: a_n = psi_n' / xi_n', b_n = psi_n / xi_n, psi = x j_n, xi = x h_n (Bohren & Huffman, ch. 4).

    The perfect conductor is the limit of an infinite refractive index. Orders up to x + 4 x^(1/3) + 3 (Wiscombe 1980).
    """
    size = 2.0 * np.pi * radius_m / wavelength_m
    order = np.arange(1, int(size + 4.0 * np.cbrt(size) + 3.0) + 1)
    regular, irregular = spherical_jn(order, size), spherical_yn(order, size)
    # (x j_n)' = j_n + x j_n'; the field along the metal vanishes: a_n by the slopes, b_n by the values
    regular_slope = regular + size * spherical_jn(order, size, derivative=True)
    irregular_slope = irregular + size * spherical_yn(order, size, derivative=True)
    return ConductingSphere(
        size,
        regular_slope / (regular_slope + 1j * irregular_slope),
        regular / (regular + 1j * irregular),
    )


def scattered_field(
    sphere: ConductingSphere,
    position_m: FloatArray,
    transmitter_m: FloatArray,
    transmitted: FloatArray,
    receiver_m: FloatArray,
) -> ComplexArray:
    """Return the direction and strength of the field at a receiver, without the distances and the phase of the path.

    E = S2 (par_i . e_tx) par_s + S1 (perp . e_tx) perp, with perp = unit(k_i x k_s) and par = k x perp.

    Parameters
    ----------
    sphere
        The tracer.
    position_m
        Its centre, shape (3, n_samples).
    transmitter_m, receiver_m
        Places of the antennas or of their images, shape (3,).
    transmitted
        Unit vector of the transmitted field, shape (3,).

    Returns
    -------
    ComplexArray
        No unit, shape (3, n_samples).
    """
    incident = _unit(position_m - transmitter_m[:, None])
    leaving = _unit(receiver_m[:, None] - position_m)
    normal = np.cross(incident, leaving, axis=0)
    # Straight on or straight back S1 and S2 are alike but for their sign: any plane through the way will do
    flat = (normal**2).sum(axis=0) < _PARALLEL
    if flat.any():
        normal[:, flat] = _any_normal(incident[:, flat])
    # the scattering plane holds both ways; the field is split across it and in it
    across = _unit(normal)
    s1, s2 = sphere.amplitudes((incident * leaving).sum(axis=0))
    in_plane = (np.cross(incident, across, axis=0) * transmitted[:, None]).sum(axis=0)
    off_plane = (across * transmitted[:, None]).sum(axis=0)
    return np.asarray(s2 * in_plane * np.cross(leaving, across, axis=0) + s1 * off_plane * across)


def _amplitude(with_pi: ComplexArray, with_tau: ComplexArray, cosine: FloatArray) -> ComplexArray:
    """Return sum (2n + 1) / (n (n + 1)) (u_n pi_n + w_n tau_n) for u = `with_pi`, w = `with_tau`."""
    order = np.arange(1, with_pi.size + 1)
    weight = _weight(with_pi.size)
    shared = weight / (order * (order + 1))
    # pi_n = P_n' and the slope in tau_n = n (n + 1) P_n - mu P_n'; the leading 0 is the order n = 0
    slope_pi = legendre.legder(np.concatenate(([0.0], shared * with_pi)))
    slope_tau = legendre.legder(np.concatenate(([0.0], shared * with_tau)))
    level = np.concatenate(([0.0], weight * with_tau))
    return np.asarray(
        legendre.legval(cosine, slope_pi) + legendre.legval(cosine, level) - cosine * legendre.legval(cosine, slope_tau)
    )


def _weight(count: int) -> FloatArray:
    return np.asarray(2.0 * np.arange(1, count + 1) + 1.0, dtype=np.float64)


def _unit(vector: FloatArray) -> FloatArray:
    return np.asarray(vector / np.sqrt((vector**2).sum(axis=0)))


def _any_normal(direction: FloatArray) -> FloatArray:
    smallest = np.abs(direction).argmin(axis=0)
    return np.asarray(np.cross(direction, np.eye(3)[smallest].T, axis=0))
