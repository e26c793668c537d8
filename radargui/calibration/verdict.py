"""Judge a fit: what the data do not determine, how left-out recordings agree, what else would fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import permutations
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from radargui.calibration.fit import MAX_STEPS, Fit, crew, fit
from radargui.calibration.likelihood import Likelihood, PathLikelihood, own_values
from radargui.calibration.unknowns import Unknown, setup_with
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.setup import Setup
from radargui.physics.path_length import path_lengths, place_antennas

UNTOLD = 0.5
"""A combination is not told whose variance is more than this share of what the setup left."""
MISFIT_M, LEFT_M = 4e-3, 5e-4
"""Root mean square of residuals that no motion leaves which is as stated: of the paths, an eighth of a fringe (a floor
that reflects 0.3 bends them by 1.5 mm), and of the samples once all mismatch is fitted."""
FAR = 4.0
"""Prior deviations beyond which a value makes one look for swapped receivers, and deviations of both it and the setup
beyond which it is none."""
ALIKE_M = 1.5e-3
"""Paths that differ by less look alike: a floor that reflects 0.3 bends them by as much."""
GAIN = 20.0
"""In cost (ln likelihood) by which another order of the receivers must be better, at a misfit of `LOOSE`."""
LOOSE = (30.0, 5.0, 1.0)
"""How much wider paths are taken from step to step (`PathLikelihood.loose`)."""
LEFT_OUT_STEPS = 6
"""At the most, in which the motion of a recording that is left out follows; to the end it took 20 s a drop."""
MAX_COMPARED = 3
"""Recordings that other orders are tried on."""
_MAX_NAMED = 3
"""Wrong orders of the receivers named in a line (chosen by hand): there are up to 47 of four."""
STEP_POINTS, RISE_POINTS = 5, 3
"""Values of a path whose medians are compared where a step is looked for: 25 ms of a drop; and how long it may take."""


class Slip(NamedTuple):
    """A lost fringe: in which recording and receiver (from 0), and when."""

    recording: int
    receiver: int
    time_s: float


def rms_m(residual_m: FloatArray) -> FloatArray:
    """Return the root mean square of each receiver's residual, shape (n_receivers,)."""
    return np.asarray(np.sqrt(np.nanmean(residual_m**2, axis=1)))


def are_far(z: FloatArray, u: FloatArray) -> BoolArray:
    """Return which values differ from the setup by more than its u and theirs allow, both in prior deviations.

    A value that the recordings determine less well than the setup may also be off by its own u.
    """
    return np.asarray(np.abs(z) > FAR * np.hypot(1.0, u))


def fit_paths(
    start: Fit, recordings: Sequence[PathLikelihood], looseness: Sequence[float] = LOOSE, steps: int = MAX_STEPS
) -> Fit:
    """Fit paths, first with wide deviations, because constraints and outliers mislead far from the solution."""
    for loose in looseness:
        start = fit(start, [replace(one, loose=loose) for one in recordings], steps=steps)
    return start


def leaned(found: Fit, numbers: Sequence[int]) -> tuple[str, ...]:
    """Return a sentence on values that are known less well than by the setup, because held values add their u.

    The release of a drop moves by 14 mm for each degree by which gravity leans, which is held at 0 +- 0.3 degrees. It
    must move with the antennas: putting it back alone raised the 3D error of twelve drops from 0.004 to 0.14 mm.
    """
    unknowns, variance = found.world.unknowns, np.diag(found.covariance())
    worse = [unknowns[n].name for n in numbers if variance[n] > 1.0]
    held = dict.fromkeys(one.group for one, is_held in zip(unknowns, found.held, strict=True) if is_held)
    if not worse:
        return ()
    by = f"what is not free counts with its uncertainty: {', '.join(held)}"
    return (f"less well known by itself than by the setup, only together with others better: {', '.join(worse)}; {by}",)


def untold(found: Fit) -> tuple[tuple[str, ...], float]:
    """Return combinations that the data do not determine, in words, and the condition number of the others.

    They are eigenvectors of the posterior covariance in prior deviations; an eigenvalue of 1 means that nothing was
    learnt.
    """
    free = ~found.held
    asked = [n for n, one in enumerate(found.world.unknowns) if free[n] and one.group]
    covariance = found.covariance()[np.ix_(asked, asked)]
    values, vectors = np.linalg.eigh(covariance)
    names = [found.world.unknowns[n] for n in asked]
    words = [_in_words(vectors[:, n], names) for n in reversed(range(values.size)) if values[n] > UNTOLD]
    # several eigenvectors may be one thing in words
    return tuple(dict.fromkeys(words)), float(np.sqrt(values[-1] / values[0]))


def _in_words(vector: FloatArray, unknowns: Sequence[Unknown]) -> str:
    """Name a combination: a common turn, a common scale, a shift, else its largest parts."""
    share = vector**2
    turned, reach = (
        [n for n, one in enumerate(unknowns) if one.name.endswith(ending) and one.group != "release"]
        for ending in ("azimuth_deg", "distance_m")
    )
    place = [n for n, one in enumerate(unknowns) if one.group == "release"]
    sideways = [n for n in place if not unknowns[n].name.endswith(".z")]
    if share[[*turned, *sideways]].sum() > 0.8 and share[turned].sum() > 0.3 and _alike(vector[turned]):
        return "a common turn of all azimuths about the vertical"
    height = [n for n in place if unknowns[n].name.endswith(".z")]
    if share[[*reach, *height]].sum() > 0.8 and len(reach) > 1 and _alike(vector[reach]):
        more = " and the height of the release" if share[height].sum() > 0.1 else ""
        return f"a common scale of all distances{more}"
    if share[place].sum() > 0.8:
        is_sideways = share[sideways].sum() > share[height].sum()
        return "a shift of the release sideways" if is_sideways else "the release's height"
    largest = [n for n in np.argsort(share)[::-1] if share[n] > 0.1][:3]
    return " with ".join(_spoken(unknowns[n].name) for n in sorted(largest))


def _spoken(name: str) -> str:
    """Name a place from which drops fell; keys of the setup are left as they are."""
    kind, _, rest = name.partition(".")
    return f"release place {rest.replace('.', ', ')}" if kind == "place" else name


def _alike(part: FloatArray) -> bool:
    return bool(part.size > 1 and abs(part.sum()) > 0.8 * np.abs(part).sum())


def left_out(found: Fit, likelihoods: Sequence[Likelihood]) -> list[FloatArray]:
    """Return what each recording leaves with the values that the others alone give, rms by receiver.

    One Gauss-Newton step from the fit of all: (I - I_k + 1) dz = s_k, I_k and s_k the recording's information and
    slope. NaN without another recording, or if the others determine nothing.
    """
    if len(likelihoods) < 2:
        return [np.full(len(one.residual_m), np.nan) for one in found.locals_]
    tasks = []
    for n, one in enumerate(likelihoods):
        # linear in the shared values: a step from the fit of all needs no new fit
        normal, slope = found.information(but=n)
        moved = found.step(normal + np.eye(slope.size), slope + found.z)
        start = Fit(found.world, found.z + moved, (found.own[n],), (), np.ones_like(found.held))
        tasks.append((one, start, len(found.locals_[n].residual_m)))
    return crew().each(_followed, tasks)


def _followed(one: Likelihood, start: Fit, n_receivers: int) -> FloatArray:
    """Return what a recording leaves, by receiver, when its motion and mismatch follow shared values that are held."""
    # damped: a whole step may end outside of all sense
    try:
        there = fit(start, [one], steps=LEFT_OUT_STEPS)
    except ProcessingError:
        return np.full(n_receivers, np.nan)
    return rms_m(there.locals_[0].residual_m)


def other_orders(setup: Setup) -> Iterator[tuple[str, Setup]]:
    """Yield what may be wrong with a setup's receivers, in words, and the setup with that put right."""
    for mirrored in (False, True):
        for order in permutations(range(setup.n_receivers)):
            if order == tuple(range(setup.n_receivers)) and not mirrored:
                continue
            receivers = [setup.receiver[k] for k in order]
            if mirrored:
                # seen in a mirror azimuths run the other way; tilts and distances stay
                receivers = [one.model_copy(update={"azimuth_deg": -one.azimuth_deg}) for one in receivers]
            yield _order_in_words(order, mirrored=mirrored), setup.model_copy(update={"receiver": tuple(receivers)})


def undecidable(found: Fit, recordings: Sequence[PathLikelihood]) -> list[str]:
    """Return what may be wrong with the receivers' order that these motions would not show, in words."""
    values = found.world.values(found.z)
    setup = setup_with(found.world.setup, found.world.unknowns, values)
    places = []
    for one, own in zip(recordings, found.own, strict=True):
        time_s = one.measured.time_s[one.motion.known(one.measured.time_s)]
        places.append(one.motion.at(time_s, values, own_values(one.motion, own))[0][0])

    def apart_m(other: Setup) -> float:
        here, there = place_antennas(setup), place_antennas(other)
        changes = [path_lengths(place, there) - path_lengths(place, here) for place in places]
        # constants are each recording's own
        return max(float(np.std(change, axis=1).max(initial=0.0)) for change in changes)

    return [words for words, other in other_orders(setup) if apart_m(other) < ALIKE_M]


def orders_words(orders: Sequence[str]) -> str:
    """Return in one line what `undecidable` found; of many some are named and the others counted; "" where none is."""
    named = orders if len(orders) <= _MAX_NAMED + 1 else orders[:_MAX_NAMED]
    more = len(orders) - len(named)
    counted = f", or the receivers come in any of {more} other orders" if more else ""
    return f"these motions cannot tell whether {', or '.join(named)}{counted}" if orders else ""


def _order_in_words(order: tuple[int, ...], *, mirrored: bool) -> str:
    moved = [n + 1 for n, other in enumerate(order) if n != other]
    swap = ""
    if len(moved) == 2:
        swap = f"receivers {moved[0]} and {moved[1]} are swapped"
    elif moved:
        swap = f"the receivers come in the order {', '.join(str(other + 1) for other in order)}"
    if not mirrored:
        return swap
    return "the azimuths run the other way round (mirror image)" + (f", and {swap}" if swap else "")


def put_right(found: Fit, recordings: Sequence[PathLikelihood]) -> tuple[list[PathLikelihood], list[Slip]]:
    """Return the recordings without the fringes that their paths lost, and where; one a receiver.

    A residual that steps by whole wavelengths within `2 STEP_POINTS` values: the count of fringes slipped, for no
    antenna's place makes a step. The samples know phases but for whole turns: they do not care.
    """
    out, slips = [], []
    for number, (one, local) in enumerate(zip(recordings, found.locals_, strict=True)):
        change = one.measured.change_m.copy()
        for receiver, residual in enumerate(local.residual_m):
            known = np.flatnonzero(np.isfinite(residual))
            if known.size < 4 * STEP_POINTS:
                continue
            medians = np.median(sliding_window_view(residual[known], STEP_POINTS), axis=1)
            step = (medians[STEP_POINTS:] - medians[:-STEP_POINTS]) / one.wavelength_m
            # the largest alone: the next one is sought when this one is right
            k = int(np.argmax(np.abs(step)))
            # medians say that it stays, the largest difference of values a few apart how far, of neighbours when
            near = residual[known[k : k + 2 * STEP_POINTS]] / one.wavelength_m
            rises = [near[lag:] - near[:-lag] for lag in (1, RISE_POINTS)]
            far = [float(rise[np.argmax(np.abs(rise))]) for rise in rises]
            fringes = next((round(x) for x in far if round(x) and abs(x - round(x)) < 0.3), 0)
            if fringes and abs(step[k]) > 0.5:
                begin = known[k + 1 + int(np.argmax(np.abs(rises[0])))]
                change[receiver, begin:] -= fringes * one.wavelength_m
                slips.append(Slip(number, receiver, float(one.measured.time_s[begin])))
        out.append(replace(one, measured=replace(one.measured, change_m=change)))
    return out, slips
