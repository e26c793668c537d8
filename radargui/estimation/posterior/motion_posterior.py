"""The posterior of a motion: all that restitution and later steps may read of a solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

from radargui.estimation.forward.motion_spline import SplineMotion
from radargui.estimation.posterior.flight_information import MotionInformation, motion_information
from radargui.estimation.posterior.floor_slope import FloorSlope, floor_slope
from radargui.estimation.posterior.free_motion import FreeMotion
from radargui.estimation.posterior.input_response import InputResponse, OtherInputs, input_responses
from radargui.estimation.select.breaks import kicks_beside
from radargui.estimation.solve.assemble import DataSums, sum_data
from radargui.estimation.solve.break_velocities import BreakVelocities, break_velocities
from radargui.estimation.solve.minimise import Solution
from radargui.model.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class MotionPosterior:
    """A motion, the velocities at its breaks with their covariance, and its likelihood for flights.

    Attributes
    ----------
    solution
        The converged solution, which is read in this module only.
    onset_s
        End of the rest.
    like
        Another posterior of which this solution is slightly moved; the sums over the data are then the same.
    """

    solution: Solution = field(repr=False)
    onset_s: float
    like: MotionPosterior | None = field(default=None, repr=False)
    _informations: dict[tuple[int, int, int, int], MotionInformation] = field(default_factory=dict, repr=False)

    @cached_property
    def free(self) -> FreeMotion:
        """The motion, of which no equation is asked."""
        solution = self.solution
        motion = SplineMotion(solution.at.spline, solution.state.coefficients)
        problem = solution.problem
        return FreeMotion(motion, problem.inputs.release_m, problem.gravity_m_s2, problem.drag)

    @cached_property
    def breaks(self) -> BreakVelocities:
        """Velocities on both sides of the breaks."""
        return break_velocities(self.solution)

    @cached_property
    def sums(self) -> DataSums:
        """Sums over the data for all unknowns, without any prior."""
        # what unseen mirrors move is linear in the state: matrix and slope of the data stay those of the best
        if self.like is not None:
            return self.like.sums
        return sum_data(self.solution.problem, self.solution.state, self.solution.at)

    @cached_property
    def floor_slope(self) -> FloorSlope | None:
        """How the floor that reflects leans; None where there is none."""
        return floor_slope(self.solution)

    def kicks_beside(self, normal: FloatArray) -> IntArray:
        """Return the numbers of the breaks beside which a wall was met that has no break, see `kicks_beside`."""
        return kicks_beside(self.free.motion, normal, self.free.gravity_m_s2)[1]

    def responses(self, others: Sequence[OtherInputs], time_s: FloatArray) -> tuple[InputResponse, ...]:
        """Return how the motion follows other inputs, see `input_responses`."""
        return input_responses(self.solution, self.sums, others, time_s)

    @property
    def is_point(self) -> bool:
        """Whether the sphere counts as a point."""
        return self.solution.problem.sphere is None

    def information(self, n_coefficients: int, n_breaks: int, lifted: slice) -> MotionInformation:
        """Return what the samples say about the first coefficients and breaks, see `motion_information`."""
        if self.like is not None:
            return self.like.information(n_coefficients, n_breaks, lifted).moved(self.solution, self.free)
        # runs of flights are tried from the longest on, and some twice
        key = n_coefficients, n_breaks, lifted.start, lifted.stop
        if key not in self._informations:
            self._informations[key] = motion_information(
                self.solution, self.sums, self.free, n_coefficients, n_breaks, lifted
            )
        return self._informations[key]


@dataclass(frozen=True, slots=True)
class AlternativeMotion:
    """A motion that the evidence does not rule out, with its weight against the best, 0 to 1."""

    posterior: MotionPosterior
    weight: float
