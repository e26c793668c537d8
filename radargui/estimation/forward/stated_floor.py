"""What the setup says of a floor as a term: T and R are what the plate reflects, as far as that is known (method 4).

T and R count from the release, and what an antenna's lobe makes of the way over the floor there is in them: q = T
exp(-j K (r0' - r0)) / (s' / s) is what the surface itself reflects, r0 and r0' the ways to the release directly and
over the floor, s and s' the lobe's field towards both. The tangential field turns over: q = -R.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.estimation.forward.lobes import LOBE_UNITS, axis_of
from radargui.estimation.forward.parameters import Layout
from radargui.estimation.forward.signal_model import ModelInputs
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.physics.mirrors import MirrorPlane, has_floor

_LEAST = 1e-6  # of |q|, whose logarithm changes with T


@dataclass(frozen=True, slots=True)
class StatedTerm:
    """Residuals in standard deviations, and how they change.

    Attributes
    ----------
    residual
        Shape (n,).
    slopes
        By theta, shape (n, layout.size).
    log_deviations
        Sum of the logarithms of the deviations: what the evidence of a prior loses.
    """

    residual: FloatArray
    slopes: FloatArray
    log_deviations: float

    @property
    def cost(self) -> float:
        """Half the sum of squares."""
        return 0.5 * float(self.residual @ self.residual)


def stated_term(theta: FloatArray, layout: Layout, inputs: ModelInputs) -> StatedTerm | None:
    """Return what a stated floor says of theta, (layout.size,); None where nothing is stated.

    Of a plate the complex R, of |R| alone the modulus: nobody knows how far below what is touched it reflects. Where
    the sphere counts as a point, R of both polarisations is what it might be.
    """
    if not has_floor(inputs.planes) or inputs.planes[0].surface is None:
        return None
    plane, surface = inputs.planes[0], inputs.planes[0].surface
    q, by_theta, cosine = _of_surface(theta, layout, inputs, plane)
    expected, u = surface.expected(cosine, inputs.wavenumber, is_point=inputs.sphere is None)
    share = -q / expected
    by_share = -by_theta / expected[:, None]
    if surface.plate is None:
        size = np.maximum(np.abs(share), _LEAST)
        residual = (size - 1.0) / u
        slopes = (np.conj(share) * by_share.T).T.real / (size * u)[:, None]
        return StatedTerm(residual, slopes, float(np.log(u).sum()))
    wrong = share - 1.0
    residual = np.concatenate([wrong.real / u, wrong.imag / u])
    slopes = np.concatenate([by_share.real / u[:, None], by_share.imag / u[:, None]])
    return StatedTerm(residual, slopes, 2.0 * float(np.log(u).sum()))


def begun_as_stated(theta: FloatArray, layout: Layout, inputs: ModelInputs) -> FloatArray:
    """Return theta with T and R as the plate has them where the plane stands; as it is where no plate is stated.

    A floor an eighth of a wave off is nearly as good with T of another phase, and that valley is not left again.
    """
    if not has_floor(inputs.planes) or inputs.planes[0].surface is None or inputs.planes[0].surface.plate is None:
        return theta
    out = theta.copy()
    _, by_theta, cosine = _of_surface(theta, layout, inputs, inputs.planes[0])
    surface = inputs.planes[0].surface
    expected, _ = surface.expected(cosine, inputs.wavenumber, is_point=inputs.sphere is None)
    for own, row, reflected in zip(_reflections(layout), by_theta, expected, strict=True):
        # what T is multiplied with is q
        t = -reflected / row[own.start]
        out[own][:2] = t.real, t.imag
    return out


def _reflections(layout: Layout) -> list[slice]:
    return [layout.transmitter_reflection, *(own.receiver_reflection for own in layout.receivers)]


def _of_surface(
    theta: FloatArray, layout: Layout, inputs: ModelInputs, plane: MirrorPlane
) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Return q, (1 + n_receivers,), its slopes by theta, and the cosines of the angle on the floor at the release."""
    unknown, release, k = layout.plane_unknowns(theta)[0], inputs.release_m, inputs.wavenumber
    points = np.array([inputs.antennas.transmitter_m, *inputs.antennas.receivers_m])
    images = plane.image(points, unknown)
    from_image = release - images
    length = np.linalg.norm(from_image, axis=1)
    way = length - np.linalg.norm(release - points, axis=1)
    by_plane = -(from_image[:, None] * plane.image_slope(points, unknown)).sum(axis=-1) / length[:, None]
    # the lobe's field over the floor, over that of the direct way
    axis = axis_of(points)
    q_direct, q_floor = (
        1.0 - (pointed * (release - at)).sum(axis=1) / np.linalg.norm(release - at, axis=1)
        for pointed, at in ((axis, points), (plane.turned(axis, unknown), images))
    )
    functions = np.stack([(q_floor - q_direct) / LOBE_UNITS[1], (q_floor**2 - q_direct**2) / LOBE_UNITS[2]], axis=-1)
    lobes = [layout.transmitter_lobe, *(own.receiver_lobe for own in layout.receivers)]
    q, by_theta = np.empty(len(points), complex), np.zeros((len(points), layout.size), complex)
    for number, (places, lobe) in enumerate(zip(_reflections(layout), lobes, strict=True)):
        back = np.exp(-1j * k * way[number] - theta[lobe][1:3] @ functions[number])
        q[number] = complex(*theta[places][:2]) * back
        row = by_theta[number]
        row[places.start], row[places.start + 1] = back, 1j * back
        row[layout.planes.start : layout.planes.start + 3] = -1j * k * by_plane[number] * q[number]
        row[lobe.start + 1 : lobe.start + 3] = -functions[number] * q[number]
    cosine = np.abs(from_image @ plane.turned_normal(unknown)) / length
    return q, by_theta, cosine
