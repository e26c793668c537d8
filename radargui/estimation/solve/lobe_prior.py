"""The prior of a wall's lobes: the wall is seen by the skirts of an antenna whose main lobe is known."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.forward.lobes import LOBE_UNITS, axis_of, main_lobe
from radargui.estimation.forward.parameters import N_LOBE, Layout
from radargui.estimation.solve.priors import Prior
from radargui.model.arrays import FloatArray
from radargui.physics.mirrors import MirrorPlane, walls_of
from radargui.physics.path_length import Antennas


@dataclass(frozen=True, slots=True)
class LobePriorSettings:
    """How far a wall's lobes may differ from those expected by the direct wave. Chosen by hand.

    Attributes
    ----------
    u_skirt, u_skirt_share
        Deviation of the slope: its least value, and its share of the main lobe's slope.
    u_transmitter
        Deviation of the transmitter's main lobe as a share.
    """

    u_skirt: float = 0.1
    u_skirt_share: float = 0.3
    u_transmitter: float = 0.5


LOBE_PRIOR = LobePriorSettings()


def main_lobes(layout: Layout, theta: FloatArray) -> FloatArray:
    """Return the exponents of the main lobes as theta has them, the transmitter's first, (1 + n_receivers,)."""
    shown = np.array([max(0.0, -theta[own.receiver_lobe][1] / LOBE_UNITS[1]) for own in layout.receivers])
    # the tracer stays near the transmitter's axis and does not show its lobe: as wide as the receivers'
    return np.append(shown.mean(), shown)


def with_lobes_of_walls(
    prior: Prior,
    layout: Layout,
    theta: FloatArray,
    planes: tuple[MirrorPlane, ...],
    antennas: Antennas,
    middle_m: FloatArray,
) -> Prior:
    """Return a prior whose walls have the lobes that are expected by theta's main lobes.

    Directly and over the floor the main lobe is seen, ln s = a q; over a wall the lobe at the angle of the wall's
    image, whose slope is that of the main lobe until it sinks into the side lobes.

    Parameters
    ----------
    prior, layout, theta
        Theta with the factors of the main lobes.
    planes, antennas
        Mirrors, antennas.
    middle_m
        Middle of the motion, shape (3,).
    """
    mean, sd = prior.mean.copy(), prior.sd.copy()
    main = -LOBE_UNITS[1] * main_lobes(layout, theta)
    shares = [LOBE_PRIOR.u_transmitter, *[LOBE_PRIOR.u_skirt_share] * len(layout.receivers)]
    places = [layout.transmitter_lobe, *(own.receiver_lobe for own in layout.receivers)]
    points = (antennas.transmitter_m, *antennas.receivers_m)
    for place, point, a, share in zip(places, points, main, shares, strict=True):
        for m, plane in enumerate(walls_of(planes), start=1):
            image, axis = plane.image(point, np.zeros(3)), plane.turned(axis_of(point), np.zeros(3))
            length = np.linalg.norm(middle_m - image)
            q = 1.0 - float(axis @ (middle_m - image) / length)
            of_angle = place.start + N_LOBE * m + 1
            # the slope where the wall's image looks: far off the axis side lobes have taken over, and it is flat
            mean[of_angle] = LOBE_UNITS[1] * float(main_lobe(np.array(-a / LOBE_UNITS[1]), np.array(q)))
            # known to a share of the main lobe's (method 4, Mirrors), no better than the least
            sd[of_angle] = LOBE_PRIOR.u_skirt + share * abs(a)
    return replace(prior, mean=mean, sd=sd)
