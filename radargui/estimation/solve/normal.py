"""The normal matrix: a band between the breaks, another over the breaks, dense in all else (method 4, Minimum)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import cho_factor, solve_triangular
from scipy.linalg.blas import dtrmm
from scipy.linalg.lapack import dtrtri
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from radargui.estimation.forward.segments import Segments
from radargui.estimation.solve.block_tridiagonal import BlockTridiagonal, padded_size
from radargui.model.arrays import FloatArray
from radargui.model.errors import SolveError

_AT_BREAK = 4
"""Unknowns of a joint: the place at a break, x, y, z, and the break's time."""
_NOT_POSITIVE = "The normal matrix of the joint estimate is not positive definite."


def solve_sparse(matrix: csr_matrix, right: FloatArray) -> FloatArray:
    """Return the solution of a sparse square system, shape as `right`.

    Raises
    ------
    SolveError
        The matrix is singular.
    """
    try:
        factor = splu(csc_matrix(matrix))
    except RuntimeError as error:  # scipy's word for an exactly singular factor
        raise SolveError("The motion is not determined: its equations are singular.") from error
    return np.asarray(factor.solve(right))


@dataclass(frozen=True, slots=True)
class NormalBlocks:
    """H = [[S, C], [C^T, M]]: motion, and global parameters of which the breaks come first.

    Attributes
    ----------
    band
        S as `lower_band` gives it, x, y and z interleaved, shape (12, n_motion).
    beside
        Coupling of each segment's functions to the breaks before and after it, shape (n_functions, 3, 2).
    c
        Coupling of the motion to the global parameters behind the breaks, shape (n_motion, n_rest).
    m
        M, shape (n_global, n_global); breaks couple to their neighbours alone.
    segments
        Which coefficients lie between which breaks.
    """

    band: FloatArray
    beside: FloatArray
    c: FloatArray
    m: FloatArray
    segments: Segments

    def diagonal_raised(self, share: float) -> NormalBlocks:
        """Return H with its diagonal raised by a share."""
        band, m = self.band.copy(), self.m.copy()
        # a share, not a sum: metres, radians and seconds stand on one diagonal (Marquardt 1963)
        band[0] *= 1.0 + share
        m[np.diag_indices(len(m))] *= 1.0 + share
        return replace(self, band=band, m=m)


@dataclass(frozen=True, slots=True)
class _Between:
    """The motion between its breaks, S_b = L L^T, and what it couples to.

    Attributes
    ----------
    motion
        Factor of S with ones in place of the joints: its segments do not touch.
    runs
        Rows of each segment.
    half
        L^-1 of the coupling to place and time of the break before, of that after, and to the global parameters behind
        the breaks, shape (rows, 8 + n_rest).
    """

    motion: BlockTridiagonal
    runs: list[slice]
    half: FloatArray

    @property
    def to_joints(self) -> FloatArray:
        """L^-1 of the coupling to the joints, shape (rows, 8)."""
        return self.half[:, : 2 * _AT_BREAK]

    @property
    def to_rest(self) -> FloatArray:
        """L^-1 of the coupling to the rest, shape (rows, n_rest)."""
        return self.half[:, 2 * _AT_BREAK :]

    @staticmethod
    def of(blocks: NormalBlocks) -> _Between:
        band, segments = blocks.band.copy(), blocks.segments
        motion_rows, n_joint = band.shape[1], 2 * _AT_BREAK
        half = np.zeros((padded_size(motion_rows), n_joint + blocks.c.shape[1]))
        to_joints, to_rest = half[:, :n_joint], half[:, n_joint:]
        # both couplings side by side: one solve for all columns
        to_rest[:motion_rows] = blocks.c
        to_joints[:motion_rows, 3::4] = segments.folded(blocks.beside)[1:].reshape(-1, 2)
        beside, flat = segments.beside_joints, segments.joint_rows.ravel()
        # what couples to a joint is taken out of the band: with ones in its place the segments no longer touch
        to_joints[beside.row, beside.side] = band[beside.near[0], beside.near[1]]
        band[beside.all[0], beside.all[1]] = 0.0
        band[0, flat], half[flat] = 1.0, 0.0
        motion = BlockTridiagonal(band)
        motion.half_solve_padded(half)
        edges = [0, *segments.joint_rows[:, 0].tolist(), motion_rows]
        return _Between(motion, [slice(a, b) for a, b in pairwise(edges)], half)

    def joints_by(self, half: FloatArray) -> FloatArray:
        """Return what L^-1 of vectors, (rows, n), takes from the joints beside each segment, (n_segments, 2, 4, n)."""
        out = np.array([self.to_joints[run].T @ half[run] for run in self.runs])
        return out.reshape(len(self.runs), 2, _AT_BREAK, -1)

    def take_joints(self, half: FloatArray, beside: FloatArray) -> None:
        """Take from L^-1 of vectors, (rows, n), what the joints beside each segment, (n_segments, 2, 4, n), add."""
        for run, one in zip(self.runs, beside.reshape(len(self.runs), 2 * _AT_BREAK, -1), strict=True):
            half[run] -= self.to_joints[run] @ one


@dataclass(frozen=True, slots=True)
class Reduced:
    """H without the motion between the breaks: joints, each coupled to the next, and the global parameters behind them.

    Attributes
    ----------
    between
        What was taken out.
    segments
        Which coefficients lie between which breaks.
    own, to_next
        Blocks of the joints and of each with the one before it, shapes (n_breaks, 4, 4) and (n_breaks - 1, 4, 4).
    to_rest
        Coupling of the joints to the rest, shape (n_breaks, 4, n_rest).
    rest
        Shape (n_rest, n_rest).
    """

    between: _Between
    segments: Segments
    own: FloatArray
    to_next: FloatArray
    to_rest: FloatArray
    rest: FloatArray

    @staticmethod
    def of(blocks: NormalBlocks) -> Reduced:
        """Take the motion between the breaks out.

        Raises
        ------
        SolveError
            It is not positive definite.
        """
        try:
            between = _Between.of(blocks)
        except np.linalg.LinAlgError as error:
            raise SolveError(_NOT_POSITIVE) from error
        segments, m = blocks.segments, blocks.m
        joints, n_breaks = segments.joint_rows, segments.n_breaks
        # Schur complement C^T S_b^-1 C, from the half solves
        rest = between.to_rest.T @ between.to_rest
        np.subtract(m[n_breaks:, n_breaks:], rest, out=rest)
        own = np.zeros((n_breaks, _AT_BREAK, _AT_BREAK))
        to_next = np.zeros((max(n_breaks - 1, 0), _AT_BREAK, _AT_BREAK))
        to_rest = np.concatenate([blocks.c[joints], m[:n_breaks, None, n_breaks:]], axis=1)
        if n_breaks:
            ends, every, elements = segments.ends, np.arange(n_breaks), segments.beside_joints
            own[:, :3, :3] = blocks.band[*elements.own]
            own[:, :3, 3] = own[:, 3, :3] = blocks.beside[ends, :, 1] + blocks.beside[ends + 1, :, 0]
            own[:, 3, 3] = m[every, every]
            to_next[:, :3, :3] = blocks.band[*elements.to_next]
            to_next[:, :3, 3] = blocks.beside[ends[1:], :, 0]
            to_next[:, 3, :3] = blocks.beside[ends[:-1] + 1, :, 1]
            to_next[:, 3, 3] = m[every[1:], every[:-1]]
            # Schur complement: a joint feels only the segments before and after it
            among = between.joints_by(between.half)
            before, after = among[:, :, :, :_AT_BREAK], among[:, :, :, _AT_BREAK : 2 * _AT_BREAK]
            own -= before[1:, 0] + after[:-1, 1]
            to_next -= before[1:-1, 1]
            to_rest -= segments.of_breaks(among[:, :, :, 2 * _AT_BREAK :])
        return Reduced(between, segments, own, to_next, to_rest, rest)

    def factor(self, added: FloatArray | None = None) -> NormalMatrix:
        """Return the factored matrix, something, (n_global,), added to the diagonal of M.

        Raises
        ------
        SolveError
            It is not positive definite, or not finite.
        """
        own, n_breaks = self.own.copy(), len(self.own)
        if added is not None:
            own[:, 3, 3] += added[:n_breaks]
        try:
            breaks = BlockTridiagonal(_joint_band(own, self.to_next))
            half = breaks.half_solve(self.to_rest.reshape(_AT_BREAK * n_breaks, len(self.rest)))
            rest = half.T @ half
            np.subtract(self.rest, rest, out=rest)
            if added is not None:
                rest[np.diag_indices(len(rest))] += added[n_breaks:]
            schur = cho_factor(rest.T, lower=True, overwrite_a=True, check_finite=False)[0]
        except np.linalg.LinAlgError as error:
            raise SolveError(_NOT_POSITIVE) from error
        if not np.isfinite(np.diag(schur)).all():  # LAPACK carries what is not a number through without a word
            raise SolveError("The normal matrix of the joint estimate is not finite.")
        return NormalMatrix(self.between, self.segments, breaks, half, schur)


@dataclass(frozen=True)
class NormalMatrix:
    """H = L L^T, in the order: motion between the breaks, joints, global parameters behind the breaks.

    Joints part the motion, so that none of it is coupled beyond the next break and all costs are linear in its length
    (nested dissection: George 1973).

    Attributes
    ----------
    between
        The first part.
    segments
        Which coefficients lie between which breaks.
    breaks
        Factor of the joints, x, y, z and time of each, without the first part.
    to_rest
        L^-1 of their coupling to the rest.
    schur
        Lower Cholesky factor of H of the rest with all motion and the breaks marginalised.
    """

    between: _Between
    segments: Segments
    breaks: BlockTridiagonal
    to_rest: FloatArray
    schur: FloatArray

    @property
    def n_breaks(self) -> int:
        """How many breaks there are."""
        return self.segments.n_breaks

    @property
    def n_global(self) -> int:
        """How many global parameters there are, with the breaks."""
        return self.n_breaks + len(self.schur)

    def half_solve(self, motion: FloatArray, of_global: FloatArray) -> FloatArray:
        """Return L^-1 of vectors given by their parts, (n_motion, n) and (n_global, n), in L's own order."""
        last, n = len(self.between.to_rest), motion.shape[1]
        end = last + len(self.to_rest)
        out = np.zeros((end + len(self.schur), n))
        out[: len(motion)] = motion
        out[self.segments.joint_rows.ravel()] = 0.0
        first = out[:last]
        self.between.motion.half_solve_padded(first)
        rest = of_global[self.n_breaks :] - self.between.to_rest.T @ first
        if self.n_breaks:
            joints = np.concatenate([motion[self.segments.joint_rows], of_global[: self.n_breaks, None]], axis=1)
            joints -= self.segments.of_breaks(self.between.joints_by(first))
            out[last : last + joints.size // n] = joints.reshape(-1, n)
            self.breaks.half_solve_padded(out[last:end])
            rest -= self.to_rest.T @ out[last:end]
        out[end:] = solve_triangular(self.schur, rest, lower=True, check_finite=False)
        return out

    def back_solve(self, half: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return both parts, (n_motion, n) and (n_global, n), of L^-T applied to vectors in L's own order."""
        last = len(self.between.to_rest)
        end = last + len(self.to_rest)
        rest = solve_triangular(self.schur, half[end:], lower=True, trans="T", check_finite=False)
        joints = self.breaks.back_solve(half[last:end] - self.to_rest @ rest)
        joints = joints.reshape(self.n_breaks, _AT_BREAK, joints.shape[1])
        first = self.between.to_rest @ rest
        np.subtract(half[:last], first, out=first)
        return self._motion_from(first, joints), np.concatenate([joints[:, 3], rest])

    def spread(self) -> tuple[FloatArray, FloatArray]:
        """Return motion, (n_motion, n_rest), and breaks, (n_breaks, n_rest), of the last columns of L^-T."""
        joints, first = self._joint_spread, self._by_rest(self.between.to_rest)
        np.negative(first, out=first)
        return self._motion_from(first, joints), joints[:, 3]

    def solve(self, motion: FloatArray, of_global: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return both parts of H^-1 applied to a vector, or to some, shapes (n_motion, ...) and (n_global, ...)."""
        half = self.half_solve(motion.reshape(len(motion), -1), of_global.reshape(len(of_global), -1))
        by_motion, by_global = self.back_solve(half)
        return by_motion.reshape(motion.shape), by_global.reshape(of_global.shape)

    def global_variances(self) -> FloatArray:
        """Return the variances of the global parameters, shape (n_global,)."""
        # M^-1 = L^-T L^-1: its diagonal needs half of the work of all of it
        rest = (self._rest_inverse**2).sum(axis=0)
        alone = self.breaks.selected_inverse(_AT_BREAK).diagonal().reshape(-1, _AT_BREAK)[: self.n_breaks, 3]
        return np.concatenate([alone + (self._joint_spread[:, 3] ** 2).sum(axis=1), rest])

    def global_covariance(self, places: slice) -> FloatArray:
        """Return the covariance of some neighbouring global parameters, shape (n, n)."""
        columns = np.eye(self.n_global)[:, places]
        motion = np.zeros((self.between.motion.size, columns.shape[1]))
        half = self.half_solve(motion, columns)
        return np.asarray(half.T @ half)

    def log_determinant(self) -> float:
        """Return ln det H."""
        # a determinant is the product of those of the Schur complements
        parts = self.between.motion.log_determinant() + self.breaks.log_determinant()
        return parts + float(2.0 * np.log(np.diag(self.schur)).sum())

    def _motion_from(self, half: FloatArray, joints: FloatArray) -> FloatArray:
        """Return the motion, (n_motion, n), of L^-T applied to vectors, in place of them where it can be."""
        if self.n_breaks:
            self.between.take_joints(half, self.segments.breaks_beside(joints))
        self.between.motion.back_solve_padded(half)
        motion = half[: self.between.motion.size]
        motion[self.segments.joint_rows] = joints[:, :3]
        return motion

    @cached_property
    def _joint_spread(self) -> FloatArray:
        """Joints of the last columns of L^-T, shape (n_breaks, 4, n_rest)."""
        joints = -self.breaks.back_solve(self._by_rest(self.to_rest))
        return np.asarray(joints.reshape(self.n_breaks, _AT_BREAK, joints.shape[1]))

    @cached_property
    def _rest_inverse(self) -> FloatArray:
        """L_rest^-1, shape (n_rest, n_rest)."""
        return np.tril(dtrtri(self.schur, lower=1)[0])

    def _by_rest(self, half: FloatArray) -> FloatArray:
        """Return half L_rest^-T, shape (n, n_rest)."""
        # a product takes half the time of a solution; transposed, rows lie as BLAS wants its columns
        return np.asarray(dtrmm(1.0, self._rest_inverse, half.T, lower=1).T) if len(half) else half


def _joint_band(own: FloatArray, to_next: FloatArray) -> FloatArray:
    """Return the `lower_band` of blocks (n, 4, 4) on the diagonal and (n - 1, 4, 4) below it."""
    out = np.zeros((2 * _AT_BREAK, _AT_BREAK * len(own)))
    for row in range(_AT_BREAK):
        for column in range(_AT_BREAK):
            if row >= column:
                out[row - column, column::_AT_BREAK] = own[:, row, column]
            out[_AT_BREAK + row - column, column : _AT_BREAK * len(to_next) : _AT_BREAK] = to_next[:, row, column]
    return out
