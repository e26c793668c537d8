"""Find impacts, where a height turns from falling to rising at once, and other sharp minima."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, median, robust_sd

THIRD_DIFFERENCE_GAIN = 20.0
"""Variance of the third difference of white noise: 1 + 9 + 9 + 1."""


@dataclass(frozen=True, slots=True)
class ImpactLimits:
    """What counts as an impact, the same for tracks, binned places and the breaks of the joint estimate.

    Attributes
    ----------
    min_jump_m_s
        Least jump of the velocity: in 10 ms gravity itself changes it by 0.1 m/s, so that a turn-round without a jump
        stays below.
    sigmas
        Least jump in its standard uncertainties: a record has some thousand instants, and waves of a mismatch have
        heavier tails than noise. Chosen by hand.
    waves
        Least jump in standard deviations of the jumps that waves of a mismatch make all along the track. Chosen by
        hand.
    min_speed_m_s
        Least speed of falling before and of rising after: after a stop in grains nothing rises. Chosen by hand.
    side_s
        Length of the one-sided parabolas whose slopes are compared: shorter ones are noisy, longer ones reach into the
        next flight of a sphere that nearly rests.
    meeting_side_s
        Length of the parabolas whose meeting gives the instant.
    clear_s
        Time left out on both sides of the instant where slopes are compared, for the instant is known to a fraction of
        a millisecond.
    shift_s
        Instants so far from the minimum are tried as well, because noise moves the minimum.
    apart_s
        Least time between two impacts.
    margin
        Least time between two impacts as a share of what gravity allows: a half, because the speeds are rough.
    track_step_s
        Length of the means that a track is reduced to first.
    min_points
        Points of a one-sided parabola, which has three coefficients.
    turn_s, smooth_s
        A sharp minimum rises within `turn_s` on both sides, smoothed over `smooth_s`.
    min_dip_m, dip_sigmas
        Least depth of a sharp minimum, and its least depth in u: 0.15 mm in 8 ms is a curvature of half of gravity.
    min_stop_m_s, stopped_share, apart_from_impact_s
        A fall ends without a rebound where its speed, `min_stop_m_s` or more, drops to `stopped_share` of itself at
        once, farther than `apart_from_impact_s` from every impact. Chosen by hand: a fall of 5 mm, and what noise
        leaves of a slope over 10 ms.
    """

    min_jump_m_s: float = 0.12
    sigmas: float = 7.0
    waves: float = 3.0
    min_speed_m_s: float = 0.04
    side_s: float = 0.010
    meeting_side_s: float = 0.030
    clear_s: float = 0.0003
    shift_s: tuple[float, ...] = (0.0, -0.001, 0.001, -0.002, 0.002)
    apart_s: float = 0.013
    margin: float = 0.5
    track_step_s: float = 0.0005
    min_points: int = 4
    turn_s: float = 0.008
    smooth_s: float = 0.002
    min_dip_m: float = 1.5e-4
    dip_sigmas: float = 6.0
    min_stop_m_s: float = 0.3
    stopped_share: float = 0.2
    apart_from_impact_s: float = 0.030

    def are_impacts(self, before_m_s: FloatArray, after_m_s: FloatArray, u_jump_m_s: FloatArray) -> BoolArray:
        """Return where a velocity falls before, rises after and jumps by enough, all shapes (n,); NaN is none."""
        turns = (before_m_s < -self.min_speed_m_s) & (after_m_s > self.min_speed_m_s)
        return np.asarray(turns & (after_m_s - before_m_s > np.maximum(self.min_jump_m_s, self.sigmas * u_jump_m_s)))


IMPACT_LIMITS = ImpactLimits()


def find_impacts(time_s: FloatArray, height_m: FloatArray, u_height_m: FloatArray, gravity_m_s2: float) -> FloatArray:
    """Return the instants of the impacts in a height, in order, shape (n_impacts,).

    Candidates are local minima. Parabolas over 10 ms on either side give the velocities there (`ImpactLimits`); the
    instant is where parabolas over up to 30 ms on either side meet. An apex or a smooth turn-round does not jump, a
    stop in a granular bed does not rise.

    Parameters
    ----------
    time_s
        Shape (n,), increasing, not necessarily even.
    height_m
        Height along the floor's normal, shape (n,); NaN where unknown: no impact is found within 10 ms of it.
    u_height_m
        Standard uncertainty of each height, shape (n,).
    gravity_m_s2
        g of the place: how long flights last.
    """
    limits, height = IMPACT_LIMITS, _Height(time_s, height_m, u_height_m, gravity_m_s2)
    if time_s.size < 2 * limits.min_points:
        return np.zeros(0)
    at = (height.minima_s()[:, None] + np.array(limits.shift_s)).ravel()
    before, after, u_jump = height.speeds(at)
    jump = after - before
    enough = limits.are_impacts(before, after, u_jump) & (jump > limits.waves * height.waves_m_s())
    significance = np.where(enough, jump / u_jump, 0.0).reshape(-1, len(limits.shift_s))
    best = np.arange(significance.shape[0]) * len(limits.shift_s) + significance.argmax(axis=1)
    best = best[significance.max(axis=1, initial=0.0) > 0.0]
    moment = at[best // len(limits.shift_s) * len(limits.shift_s)]
    kept = _possible(moment, before[best], after[best], gravity_m_s2)
    return height.meetings(moment[kept], after[best][kept])


def find_stops(
    time_s: FloatArray, height_m: FloatArray, u_height_m: FloatArray, gravity_m_s2: float, impact_s: FloatArray
) -> FloatArray:
    """Return where a fall ends at once without a rebound, shape (n_stops,).

    The height has no minimum there, only a kink. Parameters as in `find_impacts`; `impact_s` are those found.
    """
    limits, height = IMPACT_LIMITS, _Height(time_s, height_m, u_height_m, gravity_m_s2)
    if time_s.size < 2 * limits.min_points:
        return np.zeros(0)
    at = np.arange(time_s[0] + limits.side_s, time_s[-1] - limits.side_s, 0.1 * limits.side_s)
    at = at[height.may_stop(at)]
    before, after, u_jump = height.speeds(at)
    jump = after - before
    stops = (before < -limits.min_stop_m_s) & (np.abs(after) < limits.stopped_share * np.abs(before))
    stops &= jump > limits.sigmas * u_jump
    if not stops.any():
        return np.zeros(0)
    stops &= jump > limits.waves * height.waves_m_s()
    found: list[float] = []
    for k in np.flatnonzero(stops)[np.argsort(-(jump / u_jump)[stops])]:
        if np.abs(np.append(impact_s, found) - at[k]).min(initial=np.inf) > limits.apart_from_impact_s:
            found.append(float(at[k]))
    moment = np.sort(found)
    return height.meetings(moment, np.ones(moment.size))


def find_track_impacts(
    time_s: FloatArray, height_m: FloatArray, valid: BoolArray, sample_rate_hz: float, gravity_m_s2: float
) -> FloatArray:
    """Return the instants of the impacts in the height of a sampled track: `find_impacts` on means of 0.5 ms.

    Parameters
    ----------
    time_s, height_m, valid
        Shape (n_samples,); heights that are NaN or not valid are unknown.
    sample_rate_hz
        Rate of the samples.
    gravity_m_s2
        As in `find_impacts`.
    """
    size = max(1, round(IMPACT_LIMITS.track_step_s * sample_rate_hz))
    whole = height_m.size // size * size
    known = np.where(valid, height_m, np.nan)[:whole]
    share = np.full(size, 1.0 / size)
    time, height = (values.reshape(-1, size) @ share for values in (time_s[:whole], known))
    third = np.diff(height, 3)
    third = third[np.isfinite(third)]
    if third.size == 0:
        return np.zeros(0)
    # third differences: a parabola has none, and the few that an impact makes do not move their median
    noise = robust_sd(third) / np.sqrt(THIRD_DIFFERENCE_GAIN)
    # a nanometre: simulated tracks without noise keep a scale
    return find_impacts(time, height, np.full(time.size, max(noise, 1e-9)), gravity_m_s2)


def find_turns(time_s: FloatArray, height_m: FloatArray, u_height_m: FloatArray) -> FloatArray:
    """Return the times of all sharp minima of a height: impacts and what may be one, shape (n_turns,).

    A minimum counts where the height, smoothed over 2 ms, rises by more than max(0.15 mm, 6 u) within 8 ms on both
    sides, which takes a curvature of half of gravity. Parameters as in `find_impacts`.
    """
    # a third of a second to load, and only estimates need it
    from scipy.ndimage import minimum_filter1d, uniform_filter1d

    limits, known = IMPACT_LIMITS, np.isfinite(height_m)
    step = limits.track_step_s
    grid = np.arange(time_s[known][0], time_s[known][-1], step)
    width = max(1, round(limits.smooth_s / step))
    height = uniform_filter1d(np.interp(grid, time_s[known], height_m[known]), width, mode="nearest")
    reach, near = round(limits.turn_s / step), round(0.6 * limits.turn_s / step)
    least = max(limits.min_dip_m, limits.dip_sigmas * float(median(u_height_m)))
    lowest = np.flatnonzero(height <= minimum_filter1d(height, 2 * near + 1, mode="nearest"))
    lowest = lowest[(lowest >= near) & (lowest < grid.size - near)]
    # highest within the reach before and after each sample
    padded = np.pad(height, reach, mode="edge")
    around = lowest[:, None] + np.arange(reach + 1)
    left, right = padded[around].max(axis=1), padded[around + reach].max(axis=1)
    found: list[float] = []
    for k in lowest[np.minimum(left, right) - height[lowest] > least]:
        if not found or grid[k] - found[-1] >= 0.6 * limits.turn_s:
            found.append(float(grid[k]))
    return np.array(found)


def _possible(at_s: FloatArray, before_m_s: FloatArray, after_m_s: FloatArray, gravity_m_s2: float) -> list[int]:
    """Return which impacts can follow each other, the hardest first, in order.

    A sphere that leaves the floor at v comes back after 2 v / g, and one that arrives at v has fallen for v / g. An
    impact much closer to a harder one is an error of the track.
    """
    limits = IMPACT_LIMITS
    kept: list[int] = []
    # a later impact must be farther than the one, an earlier one than the other
    later, sooner = (
        np.maximum(limits.apart_s, limits.margin / gravity_m_s2 * speed).tolist()
        for speed in (2.0 * after_m_s, -before_m_s)
    )
    at = at_s.tolist()
    for index in np.argsort(before_m_s - after_m_s).tolist():
        apart = ((at[index] - at[other], other) for other in kept)
        if all(away > later[other] if away > 0.0 else -away > sooner[other] for away, other in apart):
            kept.append(index)
    return sorted(kept)


@dataclass(frozen=True, slots=True)
class _Height:
    """A height with its uncertainty, shapes (n,), and g of the place."""

    time_s: FloatArray
    height_m: FloatArray
    u_m: FloatArray
    gravity_m_s2: float

    def minima_s(self) -> FloatArray:
        """Return where the height is lowest within 6 ms on either side: less than half of `apart_s`."""
        height = np.where(np.isfinite(self.height_m), self.height_m, np.inf)
        near = 0.46 * IMPACT_LIMITS.apart_s
        first = np.searchsorted(self.time_s, self.time_s - near)
        last = np.searchsorted(self.time_s, self.time_s + near, side="right")
        around = np.minimum.reduceat(np.append(height, np.inf), np.stack([first, last], axis=1).ravel())[::2]
        return self.time_s[np.isfinite(height) & (height <= around)]

    def speeds(self, at_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the velocities just before and after some instants, and u of their difference; NaN where unknown."""
        limits, n = IMPACT_LIMITS, at_s.size
        both, u = self._parabolas(at_s, limits.clear_s, limits.side_s, limits.side_s)
        return both[:n, 1], both[n:, 1], np.hypot(u[:n], u[n:])

    def may_stop(self, at_s: FloatArray) -> BoolArray:
        """Return at which instants a fall may end, by the heights on both sides: slopes of all would cost more."""
        limits = IMPACT_LIMITS
        sides_s = at_s + np.array([-1.0, 0.0, 1.0])[:, None] * limits.side_s
        known = np.isfinite(self.height_m)
        if not known.any():
            return np.zeros(at_s.size, dtype=np.bool_)
        before, after = np.diff(np.interp(sides_s, self.time_s[known], self.height_m[known]), axis=0) / limits.side_s
        # gravity changes a mean speed, and noise of the two heights makes one
        slack = self.gravity_m_s2 * limits.side_s + limits.sigmas * self.u_m.max() / limits.side_s
        return np.asarray(
            (before < slack - limits.min_stop_m_s) & (np.abs(after) < limits.stopped_share * np.abs(before) + slack)
        )

    def waves_m_s(self) -> float:
        """Return the size of the jumps that a mismatch left in the track makes everywhere, not only at impacts."""
        side = IMPACT_LIMITS.side_s
        # nearer instants share their samples
        before, after, _ = self.speeds(np.arange(self.time_s[0] + side, self.time_s[-1] - side, side))
        jump = (after - before)[np.isfinite(after - before)]
        return robust_sd(jump - median(jump)) if jump.size else 0.0

    def meetings(self, at_s: FloatArray, after_m_s: FloatArray) -> FloatArray:
        """Return where the parabolas before and after each instant meet, near it.

        The parabolas end before the neighbouring impacts, and before a body under gravity is back, because smaller
        impacts may follow the last one found.
        """
        limits, edge = IMPACT_LIMITS, np.concatenate([self.time_s[:1], at_s, self.time_s[-1:]])
        back = np.minimum(limits.meeting_side_s, 0.9 * (at_s - edge[:-2]))
        on = 0.9 * np.minimum(edge[2:] - at_s, 2.0 * after_m_s / self.gravity_m_s2)
        on = np.minimum(limits.meeting_side_s, on)
        for _ in range(2):
            both, _ = self._parabolas(at_s, limits.track_step_s, back, on)
            c, b, a = (both[: at_s.size] - both[at_s.size :]).T
            root = b * b - 4.0 * a * c
            meets = root >= 0.0  # NaN, an unknown side, does not
            b, root = np.where(meets, b, 1.0), np.where(meets, root, 1.0)
            shift = np.where(meets, -2.0 * c / (b + np.copysign(np.sqrt(root), b)), 0.0)
            at_s = at_s + np.clip(shift, -0.4 * limits.side_s, 0.4 * limits.side_s)
        return at_s

    def _parabolas(
        self, at_s: FloatArray, clear_s: float, back_s: FloatArray | float, on_s: FloatArray | float
    ) -> tuple[FloatArray, FloatArray]:
        """Fit parabolas before all instants, then after all of them, from `clear_s` as far as `back_s` and `on_s`.

        Return height, velocity and half the curvature at the instants, and u of the velocity, shapes (2 n, 3) and
        (2 n,), NaN with fewer than four points or an unknown one. u is widened by the misfit.
        """
        begin = np.searchsorted(self.time_s, np.append(at_s - back_s, at_s + clear_s))
        end = np.searchsorted(self.time_s, np.append(at_s - clear_s, at_s + on_s), side="right")
        # both sides of all together: a call for each would cost more than the sums
        at_s = np.append(at_s, at_s)
        index = begin[:, None] + np.arange(max(int((end - begin).max(initial=0)), 1))
        inside = index < end[:, None]
        index = np.minimum(index, self.time_s.size - 1)
        height = self.height_m[index]
        known = (end - begin >= IMPACT_LIMITS.min_points) & (np.isfinite(height) | ~inside).all(axis=1)
        inside &= known[:, None]
        unit = IMPACT_LIMITS.side_s  # in which the columns are of one size
        t = (self.time_s[index] - at_s[:, None]) / unit
        weight = np.where(inside, (1.0 / self.u_m**2)[index], 0.0)
        height = np.where(inside, height, 0.0)
        # weighed sums of t^0 ... t^4 and of height t^0 ... t^2
        moments, pulls, powers = np.empty((5, at_s.size)), np.empty((3, at_s.size)), weight
        for degree in range(5):
            moments[degree] = powers.sum(axis=1)
            if degree < 3:
                pulls[degree] = np.einsum("ij,ij->i", powers, height)
            powers = powers * t
        # unknown ones get the equations of a parabola through -1, 0 and 1
        moments[:, ~known] = np.array([3.0, 0.0, 2.0, 0.0, 2.0])[:, None]
        m0, m1, m2, m3, m4 = moments
        # adjugate over determinant: a hundred times as fast as a solver called for each
        adjugate = np.array(
            [
                [m2 * m4 - m3 * m3, m2 * m3 - m1 * m4, m1 * m3 - m2 * m2],
                [m2 * m3 - m1 * m4, m0 * m4 - m2 * m2, m1 * m2 - m0 * m3],
                [m1 * m3 - m2 * m2, m1 * m2 - m0 * m3, m0 * m2 - m1 * m1],
            ]
        )
        determinant = m0 * adjugate[0, 0] + m1 * adjugate[0, 1] + m2 * adjugate[0, 2]
        solution = np.einsum("jki,ki->ij", adjugate, pulls) / determinant[:, None]
        off = height - solution[:, :1] - t * (solution[:, 1:2] + t * solution[:, 2:])
        misfit = np.einsum("ij,ij,ij->i", weight, off, off) / np.maximum(inside.sum(axis=1) - 3, 1)
        u_speed = np.sqrt(adjugate[1, 1] / determinant * np.maximum(misfit, 1.0)) / unit
        solution = np.where(known[:, None], solution / unit ** np.arange(3), np.nan)
        return solution, np.where(known, u_speed, np.nan)
