"""Compute the velocities of a solution before and after its breaks, and decide which breaks are impacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.estimation.forward.motion_spline import MotionSpline
from radargui.estimation.solve.minimise import Solution
from radargui.model.arrays import BoolArray, FloatArray
from radargui.motion.impacts import IMPACT_LIMITS


@dataclass(frozen=True, slots=True)
class BreakLimits:
    """Limits of what a body can do at a break and between two breaks, and of following it while it bounces on.

    Attributes
    ----------
    max_thrown, doubt_m_s
        Largest speed after an impact: `max_thrown` times the arrival plus `doubt_m_s`. A floor at rest returns at most
        the arrival. Chosen by hand.
    other_acceleration_m_s2
        Largest acceleration besides gravity between two breaks: three times g. Chosen by hand.
    min_flight_s
        Shortest flight that is followed while the body bounces on: a knot spacing.
    unfollowed_s
        Longest flight whose following bounce may be missed: three knot spacings. Chosen by hand.
    unseen_s
        Longest flight whose landing may have been missed if no break stands there. Chosen by hand.
    max_bounces
        Largest number of bounces: at e = 0.83 a tenth of the speed is left.
    same_share
        The share of the speed that the last impact leaves counts up to so many times the median, because a missing
        bounce may have shifted that impact. Chosen by hand.
    min_kick_m_s, kick_sigmas, sigmas_rubbed
        Least jump of the velocity along the floor at a wall, in m/s (half of `BreakSettings.kick_m_s`, which makes a
        break be tried there) and in its uncertainty; and by how many uncertainties the speed along the normal may be
        off. Chosen by hand.
    min_lost
        Least share of the speed that an impact takes: the hardest floors return 0.95.
    """

    max_thrown: float = 2.0
    doubt_m_s: float = 0.5
    other_acceleration_m_s2: float = 30.0
    min_flight_s: float = 0.010
    unfollowed_s: float = 0.030
    unseen_s: float = 0.060
    max_bounces: int = 12
    same_share: float = 1.15
    min_kick_m_s: float = 0.075
    kick_sigmas: float = 7.0
    sigmas_rubbed: float = 3.0
    min_lost: float = 0.05


LIMITS = BreakLimits()


@dataclass(frozen=True, slots=True)
class BreakSpeeds:
    """Velocities along the floor's normal at the breaks.

    Attributes
    ----------
    time_s
        Shape (n_breaks,).
    before_m_s, after_m_s, u_jump_m_s
        Same shape; up is positive.
    kick_m_s, u_kick_m_s
        Jump of the velocity along the floor, and its uncertainty, same shape.
    gravity_m_s2
        g of the place.
    """

    time_s: FloatArray
    before_m_s: FloatArray
    after_m_s: FloatArray
    u_jump_m_s: FloatArray
    kick_m_s: FloatArray
    u_kick_m_s: FloatArray
    gravity_m_s2: float

    def are_impacts(self) -> BoolArray:
        """Return at which breaks, (n_breaks,), it comes down, goes up and jumps (`ImpactLimits`), as a body could."""
        impacts = IMPACT_LIMITS.are_impacts(self.before_m_s, self.after_m_s, self.u_jump_m_s)
        return np.asarray(impacts & self.are_possible())

    def are_kicks(self) -> BoolArray:
        """Return at which breaks, (n_breaks,), the velocity along the floor jumps: a wall, or an impact that kicks.

        A wall may be met while rising. It rubs, so that it changes the speed along the normal by no more than its kick.
        """
        least = np.maximum(LIMITS.min_kick_m_s, LIMITS.kick_sigmas * self.u_kick_m_s)
        rubbed = np.abs(self.after_m_s - self.before_m_s) < self.kick_m_s + LIMITS.sigmas_rubbed * self.u_jump_m_s
        return np.asarray((self.kick_m_s > least) & (rubbed & self._are_held() | self.are_possible()))

    def are_kinks(self) -> BoolArray:
        """Return at which breaks, (n_breaks,), the velocity jumps up at all, or aside.

        A superfluous break does no harm, but a missing one bends the motion around a bounce.
        """
        return np.asarray((self.after_m_s > self.before_m_s) & self.are_possible()) | self.are_kicks()

    def are_possible(self) -> BoolArray:
        """Return at which breaks, (n_breaks,), the velocities are possible for a body.

        It is not thrown up at twice the speed of its arrival, nor was it flung down before.

        Between two breaks that are closer than the bins nothing determines the spline.
        """
        # a break between bins can swing its two sides against each other by metres a second
        thrown = self.after_m_s > LIMITS.max_thrown * np.maximum(-self.before_m_s, 0.0) + LIMITS.doubt_m_s
        return np.asarray(~thrown & self._are_held())

    def _are_held(self) -> BoolArray:
        """Return where only gravity and a push of the floor acted since the preceding break."""
        flight = np.diff(self.time_s)
        changed = np.abs(self.before_m_s[1:] - self.after_m_s[:-1] + self.gravity_m_s2 * flight)
        held = np.concatenate([[True], changed < LIMITS.doubt_m_s + LIMITS.other_acceleration_m_s2 * flight])
        return np.asarray(held[: self.time_s.size])

    def expected_impacts(self, end_s: float) -> FloatArray:
        """Return when, (n,), a body that bounces on lands after the last impact, while its flights take 10 ms or more.

        A flight that starts upward with v lasts 2 v / g; every impact takes the same share of the speed.
        """
        moment, speed, share = self._last_bounce()
        out: list[float] = []
        while len(out) < LIMITS.max_bounces:
            flight_s = 2.0 * speed / self.gravity_m_s2
            moment += flight_s
            if flight_s < LIMITS.min_flight_s or moment > end_s - LIMITS.min_flight_s:
                break
            out.append(moment)
            speed *= min(share, 1.0)
        return np.array(out)

    def bouncing_on_m(self, time_s: FloatArray) -> FloatArray:
        """Return how far from the motion a body is that bounces on unfollowed after the last impact, shape as times.

        The next flight has the height h = v^2 / 2 g and lasts T; a place anywhere in it has the standard uncertainty h
        / sqrt 12. This holds from T before the impact, which a missing bounce shifts, to 2 T after it. Then the cascade
        goes on: each flight lasts e times as long as the one before and is e^2 as high, so that the height is h (1 - t
        (1 - e) / T)^2 after a further time t, up to T / (1 - e). If no break stands at the end of a flight of 30 to 60
        ms its landing was missed, and all of this holds for the following bounce.
        """
        moment, speed, share = self._last_bounce()
        impacts = self.are_impacts()
        if impacts.sum() > 1:
            # it arrives no faster than it left, however the spline swings between two breaks
            speed = min(speed, LIMITS.same_share * share * float(self.after_m_s[impacts][-2]))
        flight_s, height_m = 2.0 * speed / self.gravity_m_s2, speed**2 / (2.0 * self.gravity_m_s2)
        if self._lands_unseen(moment, flight_s):
            # nobody knows how fast it left again: as after the impacts before
            moment, speed = moment + flight_s, min(share, 1.0) * speed
            flight_s, height_m = 2.0 * speed / self.gravity_m_s2, speed**2 / (2.0 * self.gravity_m_s2)
        # a longer one would be followed, or is not over yet
        elif not 0.0 < flight_s < LIMITS.unfollowed_s:
            return np.zeros(time_s.size)
        since = (time_s - moment) / flight_s
        left = 1.0 - np.maximum(since - 2.0, 0.0) * max(1.0 - share, LIMITS.min_lost)
        return np.where(since > -1.0, height_m / np.sqrt(12.0) * np.maximum(left, 0.0) ** 2, 0.0)

    def _lands_unseen(self, moment_s: float, flight_s: float) -> bool:
        """Return whether the flight after the last impact ends without a break; a body that comes to rest has one."""
        if not LIMITS.unfollowed_s <= flight_s < LIMITS.unseen_s:
            return False
        return not (self.time_s > moment_s + 0.5 * flight_s).any()

    def _last_bounce(self) -> tuple[float, float, float]:
        """Return the time of the last impact, the speed after it, and the share of the speed that an impact leaves."""
        impacts = self.are_impacts()
        if not impacts.any():
            return 0.0, 0.0, 0.0
        # the median: one impact may have kicked
        shares = -self.after_m_s[impacts] / self.before_m_s[impacts]
        share = float(np.median(shares))
        # the last one may have been drawn away by a bounce that is still missing
        speed = min(float(shares[-1]), LIMITS.same_share * share) * -float(self.before_m_s[impacts][-1])
        return float(self.time_s[impacts][-1]), speed, share


@dataclass(frozen=True, slots=True)
class BreakVelocities:
    """Velocities on both sides of each break.

    Attributes
    ----------
    time_s
        Shape (n_breaks,).
    before_m_s, after_m_s
        Shape (n_breaks, 3).
    covariance
        Covariance of (before x, y, z, after x, y, z) at each break, shape (n_breaks, 6, 6).
    gravity_m_s2
        g of the place.
    """

    time_s: FloatArray
    before_m_s: FloatArray
    after_m_s: FloatArray
    covariance: FloatArray
    gravity_m_s2: float

    def along(self, normal: FloatArray) -> BreakSpeeds:
        """Return the speeds along a unit vector, shape (3,), the kicks across it, and their uncertainties."""
        difference = np.concatenate([-np.eye(3), np.eye(3)], axis=1)
        across = np.eye(3) - np.outer(normal, normal)
        covariance = difference @ self.covariance @ difference.T
        u_jump = np.sqrt(np.maximum(normal @ covariance @ normal, 0.0))
        u_kick = np.sqrt(np.maximum(np.trace(across @ covariance @ across, axis1=1, axis2=2), 0.0))
        kick = np.linalg.norm((self.after_m_s - self.before_m_s) @ across, axis=1)
        before, after = self.before_m_s @ normal, self.after_m_s @ normal
        return BreakSpeeds(self.time_s, before, after, u_jump, kick, u_kick, self.gravity_m_s2)


def break_velocities(solution: Solution) -> BreakVelocities:
    """Return the velocities on both sides of each break with their covariance."""
    spline, gravity_m_s2 = solution.at.spline, solution.problem.gravity_m_s2
    moments = spline.break_s
    if moments.size == 0:
        return BreakVelocities(moments, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 6, 6)), gravity_m_s2)
    before, after = one_sided_slopes(spline)
    known, covariance = solution.normal.covariance(), np.empty((moments.size, 6, 6))
    covariance[:, :3, :3], covariance[:, 3:, 3:] = known.of_rows(before), known.of_rows(after)
    # e is a ratio of both sides, and their errors are strongly correlated: variances alone would make u_e too large
    covariance[:, :3, 3:] = known.of_rows(before, after)
    covariance[:, 3:, :3] = covariance[:, :3, 3:].transpose(0, 2, 1)
    coefficients = solution.state.coefficients
    return BreakVelocities(moments, before @ coefficients, after @ coefficients, covariance, gravity_m_s2)


def break_speeds(solution: Solution, normal: FloatArray) -> BreakSpeeds:
    """Return the speeds along a unit vector, (3,), on both sides of each break with the u of their difference."""
    return break_velocities(solution).along(normal)


def one_sided_slopes(spline: MotionSpline) -> tuple[BandedRows, BandedRows]:
    """Return the rows of the velocity just before and just after each break, n_breaks each."""
    # inside the span at the break: beyond its knot another cubic begins
    after = np.cumsum(spline.spans)[:-1]
    sides = spline.at_ends(np.concatenate([after - 1, after]), np.arange(2 * after.size) < after.size)[0]
    return sides[: after.size], sides[after.size :]
