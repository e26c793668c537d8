"""Predict the phase of a receiver whose circle hardly winds, from the other receivers or from its rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radargui.estimation.adaptive.circle_data import averaging_loss, unit_phasor
from radargui.estimation.adaptive.circle_layout import CircleLayout
from radargui.estimation.adaptive.rounds import Round, located
from radargui.estimation.forward.bins import BinnedData
from radargui.model.arrays import FloatArray
from radargui.physics.path_length import locate_falling, path_lengths, range_factor


def foretold_round(binned: BinnedData, one: Round, normal: FloatArray) -> Round:
    """Return a round whose worst receiver has the phases that the others predict, and a circle without maps.

    The places are as near to the line of fall as the other receivers' paths allow. The worst receiver is the one
    without which they are nearest to it, because a wrong count of fringes moves them sideways by centimetres.

    Parameters
    ----------
    binned
        Data of three receivers or more.
    one
        The round, with maps.
    normal
        Upward normal of the floor, shape (3,).
    """
    antennas, release, per_m = binned.antennas, binned.release_m, 2.0 * np.pi / binned.wavelength_m
    change = one.phase_rad / per_m

    def without(receiver: int) -> FloatArray:
        kept = np.arange(antennas.n_receivers) != receiver
        others = replace(antennas, receivers_m=antennas.receivers_m[kept])
        return locate_falling(change[kept], others, release, normal)

    def sideways(place: FloatArray) -> float:
        away = place - release[:, None]
        return float(((away - np.outer(normal, normal @ away)) ** 2).sum())

    places = [without(receiver) for receiver in range(antennas.n_receivers)]
    # without the wrong count the others agree on a fall that is straight
    worst = min(range(antennas.n_receivers), key=lambda receiver: sideways(places[receiver]))
    place = places[worst]
    phase = one.phase_rad.copy()
    phase[worst] = per_m * (path_lengths(place, antennas) - path_lengths(release[:, None], antennas))[worst]
    shape = range_factor(place, antennas, release)[worst] * averaging_loss(phase, binned.bins)[worst]
    moving, own = ~binned.rest, slice(2 * worst, 2 * worst + 2)
    seen = np.array([1.0, 1.0j]) @ one.value[own]
    # what is left to find of a circle whose phase is known: a complex factor and the centre, linear in the signal
    wave = np.stack([shape * unit_phasor(phase[worst]), np.ones(shape.size)], axis=1)
    turned, centre = np.linalg.lstsq(wave[moving], seen[moving], rcond=None)[0]
    return _on_circle(replace(one, phase_rad=phase, place=place, made_from=None), worst, turned, centre, shape)


HARDLY_TURNS = 2.0
"""A receiver that counts fewer turns may see none: over a floor that reflects, what comes by it winds by itself."""


def unwound_round(binned: BinnedData, one: Round) -> Round | None:
    """Return a round in which the path of the receiver with the fewest fringes keeps its length; None where it winds.

    A receiver may hardly see the motion on a level circle, where the changes of both parts of its path cancel. It then
    shows the wave over the floor, which turns several times: in one level circle 0.17 fringes were counted as 1.1, and
    the place was 18 mm off instead of 0.14.

    Parameters
    ----------
    binned
        Data of three receivers or more.
    one
        The round.
    """
    turns = np.ptp(one.phase_rad, axis=1) / (2.0 * np.pi)
    if turns.min() > HARDLY_TURNS:
        return None
    still, phase = int(turns.argmin()), one.phase_rad.copy()
    phase[still] = 0.0
    mean = (np.array([1.0, 1.0j]) @ binned.bins.value[2 * still : 2 * still + 2]).mean()
    # its circle was that of what winds; offsets are small against an echo that is tuned for it
    return located(
        binned, _on_circle(replace(one, phase_rad=phase, made_from=None), still, mean, 0.0j, np.ones(phase.shape[1]))
    )


def _on_circle(one: Round, receiver: int, turned: complex, centre: complex, shape: FloatArray) -> Round:
    """Return a round with one receiver on a circle without maps: centre, wave at rest, course of the amplitude."""
    amplitude, at_rest, fits = one.amplitude.copy(), one.rest_phase_rad.copy(), [*one.fits]
    # ln g and eps at zero, as their priors have them: a circle that hardly turns tells neither
    theta = np.zeros_like(fits[receiver].theta)
    theta[CircleLayout.constants] = centre.real, centre.imag, 0.0, 0.0, np.log(np.abs(turned))
    fits[receiver] = replace(fits[receiver], theta=theta)
    amplitude[receiver], at_rest[receiver] = np.abs(turned) * shape, np.angle(turned)
    return replace(one, rest_phase_rad=at_rest, amplitude=amplitude, fits=tuple(fits))
