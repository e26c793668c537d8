"""Where each unknown of the border stands in the parameter vector, with its prior."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from radargui.correction.joint.mirrors import FLOOR, MirrorPlane
from radargui.model.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class ReceiverLayout:
    """Places of one receiver's unknowns in the border vector.

    Attributes
    ----------
    phase, log_amplitude, log_gain, skew
        Phase and log amplitude at rest, ln g, quadrature error.
    offset
        Two: I, Q.
    bias_i, bias_q, level
        Coefficients of the maps of bias (in Z) and of log amplitude.
    backward, ghost
        Real and imaginary parts of R and X, two a mirror.
    backward_lobe
        How ln |R| changes with height, two a mirror.
    drift_i, drift_q
        Coefficients of the slow noise of each channel.
    """

    phase: int
    log_amplitude: int
    offset: slice
    log_gain: int
    skew: int
    bias_i: slice
    bias_q: slice
    level: slice
    backward: slice
    backward_lobe: slice
    ghost: slice
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


@dataclass(frozen=True, slots=True)
class Sizes:
    """Numbers of breaks, mirrors, receivers, map functions and functions of slow noise."""

    breaks: int
    mirrors: int
    receivers: int
    bias: int
    level: int
    drift: int


@dataclass(frozen=True, slots=True)
class Layout:
    """Places of all unknowns: breaks, planes, forward coefficients, then the receivers.

    Attributes
    ----------
    breaks
        Times of the impacts.
    planes
        Three a mirror: two tilts and a shift.
    forward
        Real and imaginary part of T, two a mirror.
    forward_lobe
        How ln |T| changes with height, two a mirror.
    receivers
        One a receiver.
    sizes
        The numbers it was made from.
    size
        Length of the vector.
    """

    breaks: slice
    planes: slice
    forward: slice
    forward_lobe: slice
    receivers: tuple[ReceiverLayout, ...]
    sizes: Sizes
    size: int

    @property
    def mirrors(self) -> slice:
        """Places of all that the receivers share of the mirrors."""
        return slice(self.planes.start, self.forward_lobe.stop)


def make_layout(sizes: Sizes) -> Layout:
    """Return the layout for these numbers of unknowns."""
    place = 0

    def take(count: int) -> slice:
        nonlocal place
        place += count
        return slice(place - count, place)

    breaks, planes = take(sizes.breaks), take(3 * sizes.mirrors)
    forward, forward_lobe = take(2 * sizes.mirrors), take(2 * sizes.mirrors)
    receivers = []
    for _ in range(sizes.receivers):
        phase, log_amplitude, offset = take(1).start, take(1).start, take(2)
        log_gain, skew = take(1).start, take(1).start
        bias_i, bias_q, level = take(sizes.bias), take(sizes.bias), take(sizes.level)
        backward, backward_lobe, ghost = (take(2 * sizes.mirrors) for _ in range(3))
        drift_i, drift_q = take(sizes.drift), take(sizes.drift)
        receivers.append(
            ReceiverLayout(
                phase,
                log_amplitude,
                offset,
                log_gain,
                skew,
                bias_i,
                bias_q,
                level,
                backward,
                backward_lobe,
                ghost,
                drift_i,
                drift_q,
            )
        )
    return Layout(breaks, planes, forward, forward_lobe, tuple(receivers), sizes, place)


@dataclass
class Prior:
    """Independent Gaussian priors of the border: mean and standard deviation; groups share one deviation.

    Attributes
    ----------
    mean, sd
        Shape (layout.size,).
    groups
        Index arrays whose common deviation is re-estimated (MacKay 1992), each with the range it may take.
    """

    mean: FloatArray
    sd: FloatArray
    groups: list[tuple[IntArray, float, float]] = field(default_factory=list)


BREAK_SD_S, FOUND_BREAK_SD_S = 0.003, 0.001
_LOG_AMPLITUDE_SD, _OFFSET_SD = 0.5, 0.5
_LOBE_START, _NO_LOBE = 0.03, 1e-4
_BIAS_START, _LEVEL_START, _MIRROR_START, _MOST_REFLECTED = 0.02, 0.1, 0.1, 0.2


def make_prior(
    layout: Layout,
    planes: tuple[MirrorPlane, ...],
    break_s: FloatArray,
    circles: FloatArray,
    drift_sd: FloatArray,
) -> Prior:
    """Return wide priors for the constants, narrow growing ones for maps and mirrors.

    Parameters
    ----------
    layout
        Where the unknowns stand.
    planes
        The mirrors.
    break_s
        First guesses.
    circles
        Log amplitude and offsets of I and Q where the fit starts, shape (n_receivers, 3): many fringes overrule them,
        a short arc cannot run away.
    drift_sd
        Deviations of the slow noise's coefficients, shape (n_channels, n_functions).
    """
    mean, sd = np.zeros(layout.size), np.ones(layout.size)
    mean[layout.breaks], sd[layout.breaks] = break_s, BREAK_SD_S
    sd[layout.planes] = [deviation for plane in planes for deviation in plane.deviations]
    prior = Prior(mean, sd)

    def group(places: list[slice], start: float, lowest: float, highest: float) -> None:
        index = np.concatenate([np.arange(s.start, s.stop) for s in places]).astype(np.intp)
        if index.size:
            sd[index] = start
            prior.groups.append((index, lowest, highest))

    for m in range(layout.sizes.mirrors):
        one_mirror = [_pair(layout.forward, m), *(_pair(r.backward, m) for r in layout.receivers)]
        group(one_mirror, _MIRROR_START, 1e-3, _MOST_REFLECTED)
        lobes = [_pair(layout.forward_lobe, m), *(_pair(r.backward_lobe, m) for r in layout.receivers)]
        if planes[m].name == FLOOR:
            group(lobes, _LOBE_START, 1e-3, 0.7)
        else:  # a wall's few percent do not tell how they change with height
            group(lobes, _NO_LOBE, _NO_LOBE, _NO_LOBE)
        group([_pair(r.ghost, m) for r in layout.receivers], 0.01, 1e-4, 0.3)
    for number, (own, circle) in enumerate(zip(layout.receivers, circles, strict=True)):
        sd[own.drift_i], sd[own.drift_q] = drift_sd[2 * number], drift_sd[2 * number + 1]
        mean[own.log_amplitude], mean[own.offset] = circle[0], circle[1:]
        sd[own.phase], sd[own.log_amplitude], sd[own.offset] = 10.0, _LOG_AMPLITUDE_SD, _OFFSET_SD
        sd[own.log_gain], sd[own.skew] = 0.15, 0.15
        group([own.bias_i, own.bias_q], _BIAS_START, 1e-4, 0.5)
        group([own.level], _LEVEL_START, 1e-3, 0.5)
    return prior


def _pair(places: slice, number: int) -> slice:
    return slice(places.start + 2 * number, places.start + 2 * number + 2)
