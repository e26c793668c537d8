"""The first fit, by paths: shared values, lost fringes, and recordings that do not fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.calibration.fit import MAX_STEPS, Fit, crew, unfitted
from radargui.calibration.known_path import Trajectory
from radargui.calibration.likelihood import PathLikelihood, World, own_values
from radargui.calibration.preparing import Prepared, measured_again, prepare_fall, prepare_known
from radargui.calibration.unknowns import (
    antenna_unknowns,
    fall_unknowns,
    place_unknowns,
    setup_with,
    with_polarisations,
)
from radargui.calibration.verdict import (
    FAR,
    GAIN,
    LOOSE,
    MAX_COMPARED,
    MISFIT_M,
    Slip,
    fit_paths,
    other_orders,
    put_right,
    rms_m,
)
from radargui.model.errors import ProcessingError, worded
from radargui.model.recording import Recording
from radargui.model.setup import Setup

RELEASE = "tracer.release_position_m"
MAX_SLIPS = 2
"""Lost fringes a recording that are put right: one with more is none to calibrate by."""
MIN_OTHERS, STANDS_OUT = 4, 4.0
"""From how many recordings on, and above how many times their median, one misfit is that recording's own fault: a drop
of a sound room left 7 mm, the eleven others 0.4, and the room was taken for a mirror image."""
FEW_STEPS = 12
"""Of a fit that is only compared with others."""


class UnfitFallError(ProcessingError):
    """One of the recordings is no fall, or no fall like the others.

    Attributes
    ----------
    number
        Its number.
    """

    number = 0

    @classmethod
    def of(cls, number: int, error: ProcessingError) -> UnfitFallError:
        """Return what was said of a recording."""
        out = cls(error.message, reasons=error.reasons, remedy=error.remedy)
        out.number = number
        return out


@dataclass(frozen=True)
class KnownRecording:
    """A recording and what is known of its motion.

    Attributes
    ----------
    recording
        Samples.
    name
        Unique name for people.
    checksum
        SHA-256 of the file.
    trajectory
        The known motion; None for a fall.
    release_m
        Where the sphere hung before a fall, as stated.
    """

    recording: Recording
    name: str
    checksum: str
    trajectory: Trajectory | None
    release_m: tuple[float, float, float]

    @property
    def rest_m(self) -> tuple[float, float, float]:
        """Where the sphere is before it moves."""
        if self.trajectory is None:
            return self.release_m
        x, y, z = self.trajectory.place(np.array([self.trajectory.begin_s]))[:, 0].tolist()
        return (x, y, z)


@dataclass(frozen=True)
class Rough:
    """The result of the fit by paths.

    Attributes
    ----------
    found
        The fit.
    by_paths, prepared
        Of each recording.
    slips
        Lost fringes, corrected in `by_paths`.
    """

    found: Fit
    by_paths: tuple[PathLikelihood, ...]
    prepared: tuple[Prepared, ...]
    slips: tuple[Slip, ...]


def rough_fit(recordings: Sequence[KnownRecording], setup: Setup, groups: Sequence[str]) -> Rough:
    """Fit the paths of recordings and correct lost fringes; parameters as for `calibrate`.

    Raises
    ------
    ProcessingError
        Swapped receivers, a mirror image, or another motion than stated.
    UnfitFallError
        A recording is no fall, or does not fit the others.
    """
    polarised = "polarization" in groups
    setup = with_polarisations(setup) if polarised else setup
    world, places = _world(setup, recordings, place="transmitter" in groups, polarised=polarised)
    held = np.array([bool(one.group) and one.group not in groups for one in world.unknowns])
    tasks = [(one, _hung(setup, one.rest_m), place) for one, place in zip(recordings, places, strict=True)]
    prepared = list[Prepared]()
    for number, ready in enumerate(crew().each(_prepare, tasks, crew().shares.one_done)):
        if isinstance(ready, ProcessingError):
            raise UnfitFallError.of(number, ready)
        prepared.append(ready)
    wavelength_m, is_plane = setup.radar.wavelength_m, setup.processing.geometry == "plane"
    by_paths = [PathLikelihood(ready.measured, ready.motion, wavelength_m, is_plane) for ready in prepared]
    start = unfitted(world, by_paths, held)
    rough, _, _ = _put_right(start, by_paths)
    # known motions once more against this fit: the nearer the foretold path, the fewer fringes are lost
    values = world.values(rough.z)
    better = setup_with(setup, world.unknowns, values)
    pairs = zip(prepared, rough.own, strict=True)
    prepared = [measured_again(ready, better, values, own_values(ready.motion, state)) for ready, state in pairs]
    by_paths = [replace(one, measured=ready.measured) for one, ready in zip(by_paths, prepared, strict=True)]
    rough, by_paths, slips = _put_right(start, by_paths)
    _refuse_misfit(rough, recordings)
    return Rough(rough, tuple(by_paths), tuple(prepared), tuple(slips))


def _put_right(
    start: Fit, by_paths: Sequence[PathLikelihood], looseness: Sequence[float] = LOOSE, steps: int = MAX_STEPS
) -> tuple[Fit, list[PathLikelihood], list[Slip]]:
    """Fit paths until none has lost a fringe."""
    paths, slips = list(by_paths), list[Slip]()
    while True:
        rough = fit_paths(start, paths, looseness, steps)
        righted, more = put_right(rough, paths)
        if not more or len(slips) > MAX_SLIPS * len(paths):
            return rough, paths, slips
        paths, slips = righted, slips + more


def _prepare(one: KnownRecording, setup: Setup, place: str) -> Prepared | ProcessingError:
    """Return a recording's paths, or why it is no fall."""
    if one.trajectory is not None:
        return prepare_known(one.recording, setup, one.trajectory)
    try:
        return prepare_fall(one.recording, setup, place)
    except ProcessingError as error:
        return error


def _world(
    setup: Setup, recordings: Sequence[KnownRecording], *, place: bool = False, polarised: bool = False
) -> tuple[World, list[str]]:
    """Return the shared unknowns, and the name of each recording's place (empty: a known motion)."""
    unknowns = antenna_unknowns(setup, place=place, polarised=polarised)
    names: dict[tuple[float, float, float], str] = {}
    places = []
    for one in recordings:
        if one.trajectory is not None:
            places.append("")
            continue
        if one.release_m not in names:
            # the setup's own place keeps its key, under which the value found goes back into the setup
            own = one.release_m == tuple(setup.tracer.release_position_m)
            names[one.release_m] = RELEASE if own else f"place.{len(names) + 1}"
            unknowns += place_unknowns(setup, one.release_m, names[one.release_m])
        places.append(names[one.release_m])
    if names:
        unknowns += fall_unknowns(setup)
    return World(setup, tuple(unknowns)), places


def _refuse_misfit(rough: Fit, recordings: Sequence[KnownRecording]) -> None:
    """Raise the reason why paths do not fit what is known, if they do not.

    Raises
    ------
    ProcessingError
        Swapped receivers, a mirror image, or another motion.
    """
    each = [float(np.nanmax(rms_m(one.residual_m))) for one in rough.locals_]
    worst = max(each)
    # one that lost a fringe for good draws all values along, and another order may then seem to fit better
    is_fall = recordings[int(np.argmax(each))].trajectory is None
    if is_fall and len(each) >= MIN_OTHERS and worst > STANDS_OUT * float(np.median(each)):
        refuse_above(MISFIT_M, rough, recordings)
    antennas = np.array([bool(one.key) for one in rough.world.unknowns])
    # swapped receivers may fit with antennas far from where they were measured
    if worst < MISFIT_M and np.abs(rough.z[antennas]).max(initial=0.0) < FAR:
        return
    # spread over all: neighbours may be drops from one place
    stride = max(1, len(recordings) // MAX_COMPARED)
    some = recordings[::stride][:MAX_COMPARED]

    def cost(setup: Setup, *, righted: bool = False) -> float:
        world, places = _world(setup, some)
        # paths were measured with the antennas as they were said to be: by their phases, or fringes that they foretell
        ready = [_prepare(one, _hung(setup, one.rest_m), place) for one, place in zip(some, places, strict=True)]
        # an order with which a drop is none any more is no better one
        sound = [one for one in ready if isinstance(one, Prepared)]
        if len(sound) < len(ready):
            return np.inf
        paths = [PathLikelihood(one.measured, one.motion, setup.radar.wavelength_m) for one in sound]
        asked = (unfitted(world, paths), paths, LOOSE[:2], FEW_STEPS)
        return (_put_right(*asked)[0] if righted else fit_paths(*asked)).cost

    setup = rough.world.setup
    tried = [(cost(other), words, other) for words, other in other_orders(setup)]
    least, words, best = min(tried, key=lambda one: one[0])
    # a lost fringe that another order makes up for is none: both without
    if least < cost(setup) - GAIN and cost(best, righted=True) < cost(setup, righted=True) - GAIN:
        alike = [also for other, also, _ in tried if also != words and other < least + GAIN]
        # in drops near the axis a swap looks like a mirror image of another one
        ambiguous = f"; or, which they cannot tell from that, where {'; or '.join(alike)}" if alike else ""
        raise worded(ProcessingError, "other_wiring_fits", words=words, ambiguous=ambiguous)
    refuse_above(MISFIT_M, rough, recordings)


def refuse_above(most_m: float, found: Fit, recordings: Sequence[KnownRecording]) -> None:
    """Raise the error of a recording whose motion is not the stated one, if there is one."""
    rms = [float(np.nanmax(rms_m(one.residual_m))) for one in found.locals_]
    number = int(np.argmax(rms))
    if rms[number] < most_m:
        return
    known = recordings[number].trajectory
    words = ("fall", "it was pushed as it left") if known is None else (known.words, "it belongs to another path file")
    facts = {"name": recordings[number].name, "off_mm": 1e3 * rms[number], "known": words[0], "why": words[1]}
    error = worded(ProcessingError, "off_known_motion", **facts)
    raise UnfitFallError.of(number, error) if known is None else error


def _hung(setup: Setup, place: Sequence[float]) -> Setup:
    """Return the setup with the sphere hanging at a place."""
    return setup.model_copy(update={"tracer": setup.tracer.model_copy(update={"release_position_m": tuple(place)})})
