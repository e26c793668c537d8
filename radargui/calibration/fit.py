"""Fit the motions of all recordings and the shared geometry together by damped Gauss-Newton.

Settle a fit by samples: deviations of maps and mirrors, and the noise, are re-estimated in turn with it.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, replace
from multiprocessing import active_children, get_context
from typing import TypeVar

import numpy as np

from radargui.calibration.likelihood import Likelihood, Local, World
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import ProcessingError, SolveError, worded
from radargui.system.cores import begin_worker

Progress = Callable[[float], None]
T = TypeVar("T")
_HALF_FULL_ROUNDS = 60
"""After so many rounds the fits' half of the bar is half full. Chosen by hand: the larger, the slower it goes on."""
LOOK_S = 0.1
"""How often it is looked whether somebody wants no more."""


class Shares:
    """Progress of a calibration: one estimate for each recording, then an unknown number of rounds of the fits.

    Parameters
    ----------
    report
        Given the share done.
    count
        Recordings.
    """

    def __init__(self, report: Progress, count: int) -> None:
        self._report, self._count, self._done, self._rounds = report, count, 0, 0

    def one_done(self) -> None:
        """Note that a recording was estimated."""
        self._done += 1
        self.look()

    def round_done(self) -> None:
        """Note that a step of a fit was made."""
        self._rounds += 1
        self.look()

    def look(self) -> None:
        """Report the share done; an exception from there ends the work."""
        # begun again without a recording more are done than there are; rounds never reach their half: none is the last
        estimates, rounds = min(self._done / self._count, 1.0), self._rounds / (self._rounds + _HALF_FULL_ROUNDS)
        self._report(0.5 * estimates + 0.5 * rounds)


class Crew:
    """Processes that keep what they were given from call to call; without any, this process does the work.

    Parameters
    ----------
    count
        How many; one is this process itself.
    shares
        Their progress, reported while one waits.
    """

    def __init__(self, count: int, shares: Shares | None = None) -> None:
        self.shares = shares or Shares(lambda _: None, 1)
        self._pools = [
            # one process a pool, so that a recording is always with the one that knows it; spawned, for a fork copies
            # the locks of threads that it does not copy
            ProcessPoolExecutor(1, get_context("spawn"), begin_worker)
            for _ in range(count if count > 1 else 0)
        ]
        # a pool does not tell its processes: they say their numbers themselves
        self._ids = [pool.submit(os.getpid) for pool in self._pools]

    @property
    def count(self) -> int:
        """Processes that work."""
        return max(len(self._pools), 1)

    def each(
        self, work: Callable[..., T], tasks: Sequence[tuple[object, ...]], done: Callable[[], None] = lambda: None
    ) -> list[T]:
        """Do the work on each task, the n-th always in the same process; answers come in their order."""
        if not self._pools:
            return [self._done(work(*one), done) for one in tasks]
        begun = [self._pools[n % self.count].submit(work, *one) for n, one in enumerate(tasks)]
        return [self._done(self._answer(one), done) for one in begun]

    @staticmethod
    def _done(answer: T, done: Callable[[], None]) -> T:
        done()
        return answer

    def _answer(self, begun: Future[T]) -> T:
        try:
            while not wait([begun], LOOK_S).done:
                self.shares.look()
            return begun.result()
        except BrokenProcessPool as error:
            raise worded(ProcessingError, "calibration_ended") from error

    def close(self) -> None:
        """End the processes at once, also in the middle of an estimate."""
        ids = {one.result() for one in self._ids if one.exception() is None}
        # by number: this program may have other processes, which nobody cancelled
        for process in active_children():
            if process.pid in ids:
                process.terminate()
        for pool in self._pools:
            pool.shutdown(cancel_futures=True)


_CREW: ContextVar[Crew] = ContextVar("crew", default=Crew(1))  # noqa: B039  it has no state


def crew() -> Crew:
    """Return the processes that work now."""
    return _CREW.get()


@contextmanager
def working(count: int, shares: Shares | None = None) -> Iterator[Crew]:
    """Start so many processes for `crew`, and end them afterwards."""
    here = Crew(count, shares)
    token = _CREW.set(here)
    try:
        yield here
    finally:
        _CREW.reset(token)
        here.close()


CLOSE, MAX_STEPS = 0.1, 40
"""A step that gains less in cost is the last; in so many steps it gets there or does not."""
LEAST, FEW = 1.2, 3.0
"""Least widening of u, as of all estimates with maps (method 6), and from how many differences on they are believed."""
MIN_BESIDE_WALLS = 2.0
"""The same where a wall is in the model: beside five walls the errors of a circle and a fall were up to 3.2 of the u
widened by 1.2 (the truth 63 in ln P below the solution, wherever it was sought from). Chosen by hand."""
FIRST_DAMPING, MAX_DAMPING, UP, DOWN = 1e-3, 1e6, 8.0, 2.5
"""Shares of the diagonal, and factors after a step that did not, or did, lower the cost (Marquardt 1963)."""


@dataclass(frozen=True)
class Fit:
    """The maximum of the posterior.

    Attributes
    ----------
    world
        Its unknowns.
    z, own
        The shared unknowns in prior deviations, and those of each recording.
    locals_
        Each recording at this state.
    held
        Shared unknowns that were held, shape (n,).
    least
        Least Birge ratio.
    """

    world: World
    z: FloatArray
    own: tuple[FloatArray, ...]
    locals_: tuple[Local, ...]
    held: BoolArray
    least: float = LEAST

    @property
    def cost(self) -> float:
        """Half the sum of all squares, priors included."""
        return sum(one.cost for one in self.locals_) + 0.5 * float(self.z @ self.z)

    def information(self, but: int | None = None) -> tuple[FloatArray, FloatArray]:
        """Return information and slope of the data about the shared unknowns, one recording left out where asked."""
        reduced = [one.reduced(0.0) for n, one in enumerate(self.locals_) if n != but]
        return sum(one[0] for one in reduced), sum(one[1] for one in reduced)  # type: ignore[return-value]

    def step(self, normal: FloatArray, slope: FloatArray) -> FloatArray:
        """Return the step -A^-1 g of the free unknowns, zero of those that are held, for a matrix A and a slope g."""
        free, out = ~self.held, np.zeros_like(slope)
        out[free] = -np.linalg.solve(normal[np.ix_(free, free)], slope[free])
        return out

    def birge(self) -> float:
        """Return the Birge ratio: by which factor the recordings differ more than their u allows, at least `least`."""
        square, expected = self.contradiction()
        return max(self.least, float(np.sqrt(square / expected)) if expected > FEW else self.least)

    def contradiction(self) -> tuple[float, float]:
        """Return chi-square of the recordings' differences, and their number.

        Each pulls the common values by its slope s_k, of covariance I_k: sum s_k^T (I_k + 1)^-1 s_k over its
        expectation (Birge 1932, for vectors; 1 is the prior). Errors that walls leave in maps are in no recording's own
        u.
        """
        one, square, expected = np.eye(self.z.size), 0.0, 0.0
        for local in self.locals_:
            normal, slope, _ = local.reduced(0.0)
            inverse = np.linalg.inv(normal + one)
            square += float(slope @ inverse @ slope)
            expected += float(np.trace(inverse @ normal))
        total = self.information()[0]
        # the common values were fitted to all of them: what these followed is no difference
        expected -= float(np.trace(np.linalg.solve(total + one, total)))
        return square, expected

    def covariance(self) -> FloatArray:
        """Return the covariance of the free unknowns in prior deviations; held ones count with theirs, shape (n, n).

        The information of the data is widened by the Birge ratio; no value becomes less certain than by its prior. A
        held value with a prior deviation of one shifts the others by -H_ff^-1 H_fh (Schmidt's consider parameters).
        """
        # wider data: I / B^2 + 1
        normal = self.information()[0] / self.birge() ** 2 + np.eye(self.z.size)
        free, out = ~self.held, np.zeros_like(normal)
        inverse = np.linalg.inv(normal[np.ix_(free, free)])
        follows = inverse @ normal[np.ix_(free, ~free)]
        out[np.ix_(free, free)] = inverse + follows @ follows.T
        return out


def unfitted(
    world: World, likelihoods: Sequence[Likelihood], held: BoolArray | None = None, z: FloatArray | None = None
) -> Fit:
    """Return the initial values of a fit: shared unknowns as in the setup, or z; the others at first guesses.

    `held` ones, shape (n,), stay where they are.
    """
    nothing = np.zeros(len(world.unknowns))
    held = nothing.astype(bool) if held is None else held
    return Fit(world, nothing if z is None else z, tuple(one.start for one in likelihoods), (), held)


def fit(
    start: Fit, likelihoods: Sequence[Likelihood], own: Sequence[FloatArray] | None = None, steps: int = MAX_STEPS
) -> Fit:
    """Find the maximum of the posterior.

    Parameters
    ----------
    start
        Shared unknowns to begin with, and which of them are held.
    likelihoods
        One a recording.
    own
        Initial values of the recordings' own unknowns; those of `start` if left out.
    steps
        At most.

    Raises
    ------
    ProcessingError
        The equations have no solution.
    """
    state, team = tuple(start.own if own is None else own), _Team(start.world, likelihoods)
    team.begin(start.z, state)
    now, damping = replace(start, own=state, locals_=team.locals_()), FIRST_DAMPING
    for _ in range(steps):
        crew().shares.round_done()
        better = None
        while better is None and damping <= MAX_DAMPING:
            # a step out of all sense is none: a shorter one may be one
            with suppress(np.linalg.LinAlgError, SolveError):
                better = _step(now, team, damping)
            damping = damping * UP if better is None else max(damping / DOWN, 1e-9)
        if better is None:
            break
        gain, now = now.cost - better.cost, better
        if gain < CLOSE:
            break
    if not np.isfinite(now.cost):
        raise ProcessingError("The calibration has no solution.", reasons=("a recording that is no motion as stated",))
    return now


_KEPT = threading.local()
"""What a process has of the fit under way: some of the recordings, and these at the last state that was asked for."""


def _keep(world: World, likelihoods: Sequence[Likelihood]) -> None:
    _KEPT.world, _KEPT.likelihoods = world, likelihoods


def _begin(z: FloatArray, own: Sequence[FloatArray]) -> list[float]:
    """Return the costs of what is kept at a state."""
    _KEPT.begun = [one.begun(_KEPT.world, z, state) for one, state in zip(_KEPT.likelihoods, own, strict=True)]
    return [one.cost for one in _KEPT.begun]


def _locals() -> list[Local]:
    """Return the normal equations at a state, which takes longer than the costs."""
    return [one.local() for one in _KEPT.begun]


class _Team:
    """The recordings of a fit, shared out among the processes that work."""

    def __init__(self, world: World, likelihoods: Sequence[Likelihood]) -> None:
        # one recording alone stays here: nobody else would work meanwhile
        self._crew, self._size = crew() if len(likelihoods) > 1 else Crew(1), len(likelihoods)
        self._all(_keep, [(world, one) for one in self._split(likelihoods)])

    def begin(self, z: FloatArray, own: Sequence[FloatArray]) -> list[float]:
        """Return the recordings' costs at a state."""
        return self._all(_begin, [(z, one) for one in self._split(own)])

    def locals_(self) -> tuple[Local, ...]:
        """Return all that is known there."""
        return tuple(self._all(_locals, [()] * self._crew.count))

    def _split(self, parts: Sequence[T]) -> list[Sequence[T]]:
        return [parts[n :: self._crew.count] for n in range(self._crew.count)]

    def _all(self, work: Callable[..., list[T] | None], tasks: Sequence[tuple[object, ...]]) -> list[T]:
        out: list[T] = [None] * self._size  # type: ignore[list-item]
        for n, answer in enumerate(self._crew.each(work, tasks)):
            if answer is not None:
                out[n :: self._crew.count] = answer
        return out


def _step(now: Fit, team: _Team, damping: float) -> Fit | None:
    """Return the state after a Gauss-Newton step: each recording's own eliminated, the shared solved, and back.

    None where the cost is higher: then its slopes are not computed.
    """
    reduced = [one.reduced(damping) for one in now.locals_]
    normal = sum(one[0] for one in reduced) + np.eye(now.z.size)
    slope = sum(one[1] for one in reduced) + now.z
    # Marquardt's scale: an unknown is held back by how sharply the data hold it
    normal = normal + damping * np.diag(np.diag(normal))
    moved = now.step(normal, slope)
    # back substitution: each recording's own follow the shared ones
    own = [state - back[:, -1] - back[:, :-1] @ moved for state, (_, _, back) in zip(now.own, reduced, strict=True)]
    z = now.z + moved
    if not sum(team.begin(z, own)) + 0.5 * float(z @ z) < now.cost:
        return None
    return replace(now, z=z, own=tuple(own), locals_=team.locals_())


RENEWALS, STEPS = 3, 4
"""How often the deviations of maps and the noise are re-estimated, and steps between."""
MAX_RENEWALS, SLOWLY = 12, 0.4
"""How often, and to which share each time at the least, the noise comes down from a start that is far."""
SETTLED = 10.0
"""The noise has come down where one renewal gains less than this in ln E."""
AT_LAST = 0.5
"""The same where nothing follows, a recording: a room beside a wall gained 28 in seven renewals, and moved by
0.2 mm."""


@dataclass(frozen=True)
class Settled:
    """A fit with its likelihoods, deviations of maps and mirrors re-estimated."""

    found: Fit
    likelihoods: tuple[Likelihood, ...]

    @property
    def log_evidence(self) -> float:
        """Laplace's approximation: -cost - ln det H / 2, all in prior deviations, less the noise scales' logarithms."""
        found = self.found
        # det H is that of the Schur complement times those of each recording's own
        shared = np.linalg.slogdet(found.information()[0] + np.eye(found.z.size))[1]
        own = sum(np.linalg.slogdet(one.inner)[1] for one in found.locals_)
        return float(-found.cost - 0.5 * (shared + own) - sum(one.log_widths() for one in self.likelihoods))


def settled_at_last(settled: Settled) -> Settled:
    """Return the fit with deviations re-estimated until the evidence grows no more.

    Raises
    ------
    ProcessingError, SolveError
        There is no solution.
    """
    best = settled
    for number, one in enumerate(settling(settled.found, settled.likelihoods, settled.found.own, MAX_RENEWALS)):
        gained = one.log_evidence - best.log_evidence
        best = one if gained > 0.0 else best
        # the first has the deviations that it came with
        if number and gained < AT_LAST * len(one.likelihoods):
            break
    return best


def settling(
    start: Fit, likelihoods: Sequence[Likelihood], own: Sequence[FloatArray], renewals: int = RENEWALS
) -> Iterator[Settled]:
    """Yield the fit after each renewal of the deviations of maps and mirrors, the first before any.

    Parameters
    ----------
    start
        Shared unknowns to begin with, and which of them are held.
    likelihoods, own
        One a recording, and its own unknowns to begin with.
    renewals
        How many.

    Raises
    ------
    ProcessingError, SolveError
        There is no solution.
    """
    found = start
    for number in range(renewals + 1):
        if number:
            pairs = zip(likelihoods, found.own, found.locals_, strict=True)
            likelihoods, own = zip(*(one.renewed(state, local) for one, state, local in pairs), strict=True)
        found = fit(found, likelihoods, own, STEPS)
        yield Settled(found, tuple(likelihoods))


def approach(start: Fit, likelihoods: Sequence[Likelihood], own: Sequence[FloatArray]) -> Settled:
    """Fit samples from a start that is tenths of a millimetre off, where the problem is far from linear.

    The noise is first set as large as the misfit, so that priors hold what is hardly determined, and is reduced with
    it. Parameters and errors as for `settling`.
    """
    locals_: Sequence[Local] = [one.at(start.world, start.z, z) for one, z in zip(likelihoods, own, strict=True)]
    found, least, widths = start, 1.0, np.inf
    for _ in range(MAX_RENEWALS):
        likelihoods = [one.scaled(local.misfit, least) for one, local in zip(likelihoods, locals_, strict=True)]
        before, widths = widths, sum(one.log_widths() for one in likelihoods)
        # the noise is down to what the motion leaves of the samples: from here on deviations are re-estimated, too
        if widths > before - SETTLED:
            break
        found = fit(found, likelihoods, own, STEPS)
        own, locals_, least = found.own, found.locals_, SLOWLY
    *_, last = settling(found, likelihoods, own)
    return last
