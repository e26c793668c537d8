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
    """What a body can do at a break and between two of them, and how far it is followed bouncing on.

    Attributes
    ----------
    most_thrown, doubt_m_s
        Not thrown up faster than this many times the arrival, and this much more: a floor gives back at most the speed
        itself. Chosen by hand.
    other_acceleration_m_s2
        What acts besides gravity between two breaks, at most: three times g. Chosen by hand.
    least_flight_s
        Bouncing on: a flight shorter than a knot spacing is not followed.
    unfollowed_s
        Up to three knot spacings it may not be followed. Chosen by hand.
    unseen_s
        Up to so long a flight's end may have been missed, where no break stands there. Chosen by hand.
    most_bounces
        So many at most: a tenth of the speed is left at e = 0.83.
    same_share
        The last impact's share of the speed counts up to so many times the median, since a missing bounce may have
        drawn it away. Chosen by hand.
    least_kick_m_s, kick_sigmas, sigmas_rubbed
        A wall throws a body back by so much along the floor at least, and by so many uncertainties: half of what makes
        a break be tried there (`BreakSettings.kick_m_s`); by how many the speed along the normal may be off. Chosen by
        hand.
    least_lost
        Every impact takes so much of the speed at least: the hardest floors give back 0.95.
    """

    most_thrown: float = 2.0
    doubt_m_s: float = 0.5
    other_acceleration_m_s2: float = 30.0
    least_flight_s: float = 0.010
    unfollowed_s: float = 0.030
    unseen_s: float = 0.060
    most_bounces: int = 12
    same_share: float = 1.15
    least_kick_m_s: float = 0.075
    kick_sigmas: float = 7.0
    sigmas_rubbed: float = 3.0
    least_lost: float = 0.05


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

        A wall is met rising, too, and rubs: it changes the speed along the normal by no more than its kick.
        """
        least = np.maximum(LIMITS.least_kick_m_s, LIMITS.kick_sigmas * self.u_kick_m_s)
        rubbed = np.abs(self.after_m_s - self.before_m_s) < self.kick_m_s + LIMITS.sigmas_rubbed * self.u_jump_m_s
        return np.asarray((self.kick_m_s > least) & (rubbed & self._are_held() | self.are_possible()))

    def are_kinks(self) -> BoolArray:
        """Return at which breaks, (n_breaks,), the velocity jumps up at all, or aside.

        A weak break costs nothing; one taken away again bends the motion around it when a bounce was there.
        """
        return np.asarray((self.after_m_s > self.before_m_s) & self.are_possible()) | self.are_kicks()

    def are_possible(self) -> BoolArray:
        """Return where, (n_breaks,), a body could do so: not thrown up at twice the speed, nor flung down before.

        Between two breaks closer than the bins the spline is held by nothing.
        """
        # a break between bins can swing its two sides against each other by metres a second
        thrown = self.after_m_s > LIMITS.most_thrown * np.maximum(-self.before_m_s, 0.0) + LIMITS.doubt_m_s
        return np.asarray(~thrown & self._are_held())

    def _are_held(self) -> BoolArray:
        """Return where nothing but gravity and a push of the floor acted since the break before."""
        flight = np.diff(self.time_s)
        changed = np.abs(self.before_m_s[1:] - self.after_m_s[:-1] + self.gravity_m_s2 * flight)
        held = np.concatenate([[True], changed < LIMITS.doubt_m_s + LIMITS.other_acceleration_m_s2 * flight])
        return np.asarray(held[: self.time_s.size])

    def expected_impacts(self, end_s: float) -> FloatArray:
        """Return when, (n,), a body that bounces on lands after the last impact, while its flights take 10 ms or more.

        A flight that starts upward with v lasts 2 v / g; every impact takes away the same share of the speed.
        """
        moment, speed, share = self._last_bounce()
        out: list[float] = []
        while len(out) < LIMITS.most_bounces:
            flight_s = 2.0 * speed / self.gravity_m_s2
            moment += flight_s
            if flight_s < LIMITS.least_flight_s or moment > end_s - LIMITS.least_flight_s:
                break
            out.append(moment)
            speed *= min(share, 1.0)
        return np.array(out)

    def bouncing_on_m(self, time_s: FloatArray) -> FloatArray:
        """Return how far from the motion a body is that bounces on unfollowed after the last impact, shape as times.

        The next flight's height h = v^2 / 2 g, anywhere in it: h / sqrt 12. From as long before the impact, which a
        bounce that is missing draws away, as the flight lasts, T, to twice as long after it. From there on it goes on
        as a cascade does: each flight lasts e times the one before and is e^2 as high, so that after t more of
        T / (1 - e) the height is h (1 - t (1 - e) / T)^2. Of a flight of 30 to 60 ms at whose end no break stands the
        landing was missed: then all of this holds for the bounce after it.
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
        left = 1.0 - np.maximum(since - 2.0, 0.0) * max(1.0 - share, LIMITS.least_lost)
        return np.where(since > -1.0, height_m / np.sqrt(12.0) * np.maximum(left, 0.0) ** 2, 0.0)

    def _lands_unseen(self, moment_s: float, flight_s: float) -> bool:
        """Whether no break stands where the flight after the last impact ends: what lies still there has one."""
        if not LIMITS.unfollowed_s <= flight_s < LIMITS.unseen_s:
            return False
        return not (self.time_s > moment_s + 0.5 * flight_s).any()

    def _last_bounce(self) -> tuple[float, float, float]:
        """Return when the last impact is, the speed after it, and the share of the speed that an impact leaves."""
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
        Of (before x, y, z, after x, y, z) at each break, shape (n_breaks, 6, 6).
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
