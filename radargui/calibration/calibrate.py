"""Calibrate a setup from recordings and from what is known of their motions."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import gammainccinv

from radargui import __version__
from radargui.calibration.fit import (
    FEW,
    MIN_BESIDE_WALLS,
    Fit,
    Progress,
    Settled,
    Shares,
    approach,
    fit,
    settled_at_last,
    unfitted,
    working,
)
from radargui.calibration.likelihood import Likelihood, PathLikelihood, own_values
from radargui.calibration.preparing import Prepared, sample_problem
from radargui.calibration.rough_fit import RELEASE, KnownRecording, UnfitFallError, refuse_above, rough_fit
from radargui.calibration.signal_likelihood import SignalLikelihood
from radargui.calibration.unknowns import USUAL, setup_with
from radargui.calibration.verdict import (
    FAR,
    LEFT_M,
    LOOSE,
    are_far,
    fit_paths,
    leaned,
    left_out,
    orders_words,
    rms_m,
    undecidable,
    untold,
)
from radargui.calibration.wall_search import n_mirrors, planes_of, some_of, with_walls
from radargui.model.arrays import FloatArray
from radargui.model.calibration import Calibration, Origin, Residual
from radargui.model.errors import ProcessingError, SolveError, worded
from radargui.model.setup import Setup
from radargui.system.cores import one_blas_thread

CONTRADICTION = 3.0
"""Birge ratio beyond which u would have to be widened so much that it means nothing: circles beside strong walls had
4.9 and were up to 4 of the widened u off, sound ones 1.2 to 2.3. Chosen by hand."""
CHANCE = 1e-4
"""With which a sound calibration may be refused for its Birge ratio: of six differences, as a circle and a fall have,
it is 2.15 times what it should be once in so many. Beside a wall u counts twice: three of twenty rooms had 3.0 to 3.5,
with all values inside 2u."""
MAX_UNFIT = 1.0 / 3.0
"""Share of the recordings that are left out because they are no falls, pushed ones, or such in which a receiver loses
fringes: in one of 101 rooms one did in all drops from one place of three, where its echo is as weak as the floor's."""


Made = tuple[str, str]
"""When a calibration was made, and by whom."""


@dataclass(frozen=True)
class Calibrated:
    """A calibration, the setup with its values, and the fit.

    Attributes
    ----------
    calibration
        For the file.
    setup
        With the values and their u; its own where the calibration is refused.
    fit
        Unknowns and covariance of everything.
    """

    calibration: Calibration
    setup: Setup
    fit: Fit


def calibrate(
    recordings: Sequence[KnownRecording],
    setup: Setup,
    groups: Sequence[str] = USUAL,
    *,
    progress: Progress = lambda _: None,
    workers: int = 1,
    made_at: str = "",
    operator: str = "",
    fit: Callable[[Sequence[KnownRecording], Setup, Sequence[str], Made], Calibrated] | None = None,
) -> Calibrated:
    """Find the antennas from recordings of motions that are known but for a few unknowns.

    Parameters
    ----------
    recordings
        At least one.
    setup
        Stated places of the antennas, with their uncertainties.
    groups
        The groups that are free (`unknowns.GROUPS`); the others stay where they are, and their uncertainty counts.
    progress
        Called with the share done; what it raises ends the work.
    workers
        Processes for the estimates of the recordings.
    made_at, operator
        For its origin.
    fit
        Fits recordings that are all as they should be; None: paths first, then samples and walls.

    Raises
    ------
    ProcessingError
        Recordings do not fit what is known of them: swapped receivers, a mirror image, no overlap. Of many falls some
        may not fit; these are left out, and the calibration's notes say so.
    """
    shares, given, unfit = Shares(progress, len(recordings)), list(recordings), list[UnfitFallError]()
    # more processes than recordings would find nothing to do
    with one_blas_thread(), working(min(workers, len(recordings)), shares):
        while True:
            try:
                found = (fit or _calibrated)(given, setup, groups, (made_at, operator))
                break
            except UnfitFallError as error:
                unfit.append(error)
                # of a dozen drops some were pushed; where most are unfit something else is wrong
                if len(unfit) > MAX_UNFIT * len(recordings):
                    raise unfit[0] from None
                del given[error.number]
    progress(1.0)
    left_out = tuple(f"left out: {error.message}" for error in unfit)
    return replace(found, calibration=replace(found.calibration, notes=found.calibration.notes + left_out))


def _calibrated(recordings: Sequence[KnownRecording], setup: Setup, groups: Sequence[str], origin: Made) -> Calibrated:
    found_roughly = rough_fit(recordings, setup, groups)
    rough, by_paths, prepared = found_roughly.found, found_roughly.by_paths, found_roughly.prepared
    world, setup = rough.world, rough.world.setup
    # antennas as the setup has them: what this leaves stands in the file as before
    before = fit_paths(unfitted(world, by_paths, np.array([bool(one.key) for one in world.unknowns])), by_paths)
    likelihoods, own = _sharpened(rough, by_paths, prepared)
    normal, few = np.asarray(setup.floor.normal), some_of(likelihoods)
    bare = approach(rough, [likelihoods[n] for n in few], [own[n] for n in few])
    n_bare, settled = n_mirrors(bare), with_walls(bare, normal)
    beginning = Beginning(rough, by_paths, tuple(likelihoods), tuple(own))
    # where the walls are a few recordings say as well as all, in a fraction of the time
    if len(few) < len(likelihoods):
        settled = begun_with(beginning, settled, n_bare, normal)
    settled = settled_at_last(begun_again(beginning, settled, n_bare, normal))
    found = fit(settled.found, settled.likelihoods)
    # a wall's reflection is described less well than noise: u must say so
    if n_mirrors(settled) > n_bare:
        found = replace(found, least=MIN_BESIDE_WALLS)
    if not np.isfinite(found.information()[0]).all():
        raise worded(ProcessingError, "samples_disagree")
    # with all mismatch fitted half a millimetre is left by no motion that was as stated
    refuse_above(LEFT_M, found, recordings)
    calibration = _calibration(found, before, settled.likelihoods, recordings, origin)
    lost = tuple(
        f"{recordings[number].name}: receiver {receiver + 1} lost a fringe near {time_s:.3f} s, put right"
        for number, receiver, time_s in found_roughly.slips
    )
    untold = orders_words(undecidable(rough, by_paths))
    calibration = replace(calibration, notes=(*calibration.notes, *lost, *filter(None, (untold,))))
    return Calibrated(calibration, calibrated_setup(setup, found, calibration), found)


def _sharpened(
    rough: Fit, by_paths: Sequence[PathLikelihood], prepared: Sequence[Prepared]
) -> tuple[list[Likelihood], list[FloatArray]]:
    """Return likelihoods by samples of recordings with a rest, by paths of the others, and initial values."""
    values = rough.world.values(rough.z)
    better = setup_with(rough.world.setup, rough.world.unknowns, values)
    out, starts = list[Likelihood](), list[FloatArray]()
    for path, ready, state, local in zip(by_paths, prepared, rough.own, rough.locals_, strict=True):
        begun = None if path.is_plane else sample_problem(ready, better, values, own_values(ready.motion, state))
        if begun is None:
            # neighbours share their error: one value counts for a quarter of a fringe
            change = path.measured.change_m
            turns = float((np.nanmax(change, axis=1) - np.nanmin(change, axis=1)).max()) / path.wavelength_m
            crowd = max(1.0, path.measured.time_s.size / (4.0 * max(turns, 1.0)))
            u_m = float(max(rms_m(local.residual_m).max(), 1e-5) * np.sqrt(crowd))
            out.append(replace(path, measured=replace(path.measured, u_m=u_m)))
        else:
            out.append(SignalLikelihood(begun.problem, begun.state.theta, ready.motion))
            state = np.concatenate([state[: len(ready.motion.own)], np.zeros(begun.state.theta.size)])
        starts.append(state)
    return out, starts


def _calibration(
    found: Fit, before: Fit, likelihoods: Sequence[Likelihood], recordings: Sequence[KnownRecording], origin: Made
) -> Calibration:
    unknowns = found.world.unknowns
    # gravity, drag and floor belong to these recordings: marginalised, they stay out of the file
    kept = [n for n, one in enumerate(unknowns) if not found.held[n] and (one.key or one.name.startswith(RELEASE))]
    u = np.array([unknowns[n].u for n in kept])
    mean = np.array([unknowns[n].value for n in kept])
    # unknowns are in prior deviations, the file in degrees and metres
    covariance = np.outer(u, u) * found.covariance()[np.ix_(kept, kept)]
    words, condition_number = untold(found)
    shrunk = np.sqrt(np.diag(covariance)) / u
    antennas = np.array([bool(unknowns[n].key) for n in kept])
    verdict, reason = "good", "every combination of the values is told better by the recordings than by the setup"
    if words:
        verdict = "usable"
        reason = f"what the recordings cannot tell is known no better than the setup says: {'; '.join(words)}"
    # at 0.7 of its u half of what is known of a value comes from the recordings
    if not (shrunk[antennas] < 0.7).any():
        verdict = "refused"
        reason = (
            "the path is too short or too simple to tell any antenna better than the setup does (condition number "
            f"{condition_number:.3g})"
        )
    if found.birge() > max_birge(found):
        verdict = "refused"
        reason = (
            f"the recordings contradict each other {found.birge():.1f} times more than each says of itself: a wall "
            "close to the motion reflects, or a motion was not as stated"
        )
    far = [unknowns[kept[n]].name for n in np.flatnonzero(are_far(found.z[kept], shrunk))]
    if far:
        verdict = "refused"
        reason = (
            f"{', '.join(far)} would be more than {FAR:g} of its u away from the setup: that u is too small, or a wall "
            "or another motion than stated bends the paths"
        )
    residuals = []
    alone = left_out(found, likelihoods)
    for one, now, then, other in zip(recordings, found.locals_, before.locals_, alone, strict=True):
        for n, (a, b, c) in enumerate(zip(rms_m(now.residual_m), rms_m(then.residual_m), other, strict=True), 1):
            residuals.append(Residual(one.name, n, float(a), float(b), float(c)))
    names = tuple(unknowns[n].name for n in kept)
    known = tuple("fall" if one.trajectory is None else one.trajectory.words for one in recordings)
    files = {one.name: one.checksum for one in recordings}
    notes = (
        f"condition number {condition_number:.3g}",
        f"u widened by {found.birge():.2f} (Birge ratio)",
        *leaned(found, kept),
    )
    return Calibration(
        names, mean, mean + u * found.z[kept], u, covariance, words, tuple(residuals), verdict, reason,
        Origin(*origin, __version__, files, known), notes,
    )  # fmt: skip


def max_birge(found: Fit) -> float:
    """Return the largest Birge ratio that chance allows.

    For nu differences with the assumed deviations, B^2 nu / least^2 follows chi^2 with nu degrees of freedom.
    """
    differences = found.contradiction()[1]
    by_chance = np.sqrt(2.0 * gammainccinv(0.5 * differences, CHANCE) / differences) if differences > FEW else 1.0
    return max(CONTRADICTION, found.least * float(by_chance))


def calibrated_setup(setup: Setup, found: Fit, calibration: Calibration) -> Setup:
    """Return the setup with the values found and their u; unchanged where the calibration is refused."""
    if calibration.verdict == "refused":
        return setup
    values = dict(zip(calibration.names, calibration.values.tolist(), strict=True))
    # by what they belong to: "receiver.1" has u_tilt_deg, a place in coordinates u_x, u_y, u_z
    u: dict[str, dict[str, float]] = defaultdict(dict)
    for name, own in zip(calibration.names, np.sqrt(np.diag(calibration.covariance)).tolist(), strict=True):
        place, _, key = name.rpartition(".")
        u[place][f"u_{key}"] = own
    setup, sender = setup_with(setup, found.world.unknowns, values), u["transmitter"]
    # a setup has one u for all coordinates of a place: the largest promises nothing that one of them does not hold
    if coordinates := u["transmitter.position_m"]:
        sender["u_distance_m"] = max(coordinates.values())
    receivers = tuple(one.model_copy(update=u[f"receiver.{n}"]) for n, one in enumerate(setup.receiver, 1))
    changed = {"transmitter": setup.transmitter.model_copy(update=sender), "receiver": receivers}
    if release := u[RELEASE]:
        at = tuple(values[f"{RELEASE}.{axis}"] for axis in "xyz")
        tracer = {"release_position_m": at, "u_release_m": max(release.values())}
        changed["tracer"] = setup.tracer.model_copy(update=tracer)
    return setup.model_copy(update=changed)


MAX_TIMES, GAINED = 2, 10.0
"""How often it begins again, and the gain in ln E with which it does so once more."""
DISAGREEING = 1.5
"""Birge ratio from which it begins again: recordings that agree have not gone astray."""


@dataclass(frozen=True)
class Beginning:
    """The initial values of the fit by samples.

    Attributes
    ----------
    rough
        The fit by paths.
    by_paths
        Its likelihoods.
    likelihoods, own
        By samples, as first guessed, and the recordings' own unknowns there.
    """

    rough: Fit
    by_paths: tuple[PathLikelihood, ...]
    likelihoods: tuple[Likelihood, ...]
    own: tuple[FloatArray, ...]


def begun_again(
    beginning: Beginning, settled: Settled, n_bare: int, normal: FloatArray, disagreeing: float = DISAGREEING
) -> Settled:
    """Return the better of a fit and of fits that begin anew with its antennas and walls only.

    While a wall is missing, paths may be off by 2 mm and samples by tenths of the signal. In one room a fall had moved
    5 mm for that and stayed there after the wall was found, with its floor turned round, 300 in ln E behind.

    Parameters
    ----------
    beginning
        What it began with.
    settled
        The fit so far.
    n_bare
        Mirrors that it began with.
    normal
        Upward normal of the floor, shape (3,).
    disagreeing
        Birge ratio from which it begins again.
    """
    best = settled
    for _ in range(MAX_TIMES):
        # paths alone have no mirrors, and nothing to go astray in
        if n_mirrors(best) == 0 or best.found.birge() < disagreeing:
            break
        try:
            again = begun_with(beginning, best, n_bare, normal)
        except (ProcessingError, SolveError):
            break
        gained = again.log_evidence - best.log_evidence
        best = again if gained > 0.0 else best
        if gained < GAINED:
            break
    return best


def begun_with(beginning: Beginning, settled: Settled, n_bare: int, normal: FloatArray) -> Settled:
    """Return all recordings' fit, begun with the antennas and walls of another, maybe of a few; parameters as above.

    Raises
    ------
    ProcessingError, SolveError
        There is no solution.
    """
    found, rough, walls = settled.found, beginning.rough, planes_of(settled, n_bare, normal)
    antennas = np.array([bool(one.key) for one in found.world.unknowns])
    # places and motions by paths, only as sharply as what bends these lets them say
    start = unfitted(found.world, beginning.by_paths, rough.held | antennas, np.where(antennas, found.z, 0.0))
    motions = fit_paths(start, beginning.by_paths, LOOSE[:2])
    likelihoods, states = list[Likelihood](), []
    for one, own, state in zip(beginning.likelihoods, beginning.own, motions.own, strict=True):
        if isinstance(one, SignalLikelihood):
            # of a fit by paths only the motion is the same thing: what follows there is a receiver's slow errors
            state = np.concatenate([state[: one.n_motion], own[one.n_motion :]])
        if walls:
            one, state = one.with_mirrors(walls, state)
        likelihoods.append(one)
        states.append(state)
    return approach(replace(motions, held=rough.held), likelihoods, states)
