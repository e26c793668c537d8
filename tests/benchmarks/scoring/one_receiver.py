"""Is what `process` says of a scene right, refused, or silently wrong?

Silently wrong (issue 10), each enough by itself:

* status ok, and over more than 5 % of the moments called valid the change of path is off by more than 0.3 wavelength
  and by more than 10 %;
* a path that goes on with the same zero (the same piece) over samples that are not valid, and is half a wavelength or
  more off behind them against before;
* motion reported where nothing moves; no_motion where a knowable target moves.

Right: status ok, and at least 90 % of the knowable moments are called valid and are right.
With several targets a moment is right by any whose echo is at least 0.7 of the strongest there.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from benchmarks.world.one_receiver.scene import Scene, runs

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.result import PathLengths, RunResult

OFF_WAVELENGTHS = 0.3
OFF_SHARE = 0.1
WRONG_SHARE = 0.05
JUMP_WAVELENGTHS = 0.5
RIGHT_SHARE = 0.9
MAX_VALID = 0.8
"""A moment counts as called valid from this share of its samples on: single clipped samples may be left out."""
EQUAL_ECHO = 0.7
GAIN_BOUNDS = (0.5, 2.0)
QUADRATURE_BOUND_DEG = 45.0


@dataclass(frozen=True, slots=True)
class Judgement:
    """What came out of one scene under one correction.

    Attributes
    ----------
    status, reason
        As processed; "raised" and the error, or "out of time", where there is no result.
    wrong
        Why it is silently wrong; empty where it is not.
    right
        Whether a knowable scene came out right.
    valid_share, right_share
        Of the knowable moments: called valid; called valid and right. NaN where none is knowable.
    gain_sigmas, quadrature_sigmas
        Departure from the truth in standard uncertainties; NaN where not told.
    out_of_bounds
        Whether a front end is claimed that no mixer has.
    valid_though_refused
        Whether samples are called valid though the status is not ok.
    processor_s
        Processor time.
    """

    status: str
    reason: str = ""
    wrong: str = ""
    right: bool = False
    valid_share: float = np.nan
    right_share: float = np.nan
    gain_sigmas: float = np.nan
    quadrature_sigmas: float = np.nan
    out_of_bounds: bool = False
    valid_though_refused: bool = False
    processor_s: float = 0.0


def judge(scene: Scene, result: RunResult, processor_s: float) -> Judgement:
    """Return how right a result is."""
    claimed = None if result.paths is None else result.paths.valid[0]
    refused_valid = result.status != "ok" and claimed is not None and bool(claimed.any())
    if result.status != "ok" or result.paths is None:
        missed = result.status == "no_motion" and scene.expected == "ok"
        wrong = "no_motion, but a knowable target moves" if missed else ""
        return Judgement(
            result.status, result.reason, wrong, valid_though_refused=refused_valid, processor_s=processor_s
        )
    moments = _moments(scene, result.paths, _first_stored(result))
    wrong = _wrong(scene, result, moments)
    known = scene.knowable
    valid_share = float(moments.valid[known].mean()) if known.any() else np.nan
    right_share = float(moments.right[known].mean()) if known.any() else np.nan
    gain_sigmas, quadrature_sigmas, out_of_bounds = _front_end(scene, result)
    return Judgement(
        status="ok",
        reason=result.reason,
        wrong=wrong,
        right=scene.expected == "ok" and not wrong and right_share >= RIGHT_SHARE,
        valid_share=valid_share,
        right_share=right_share,
        gain_sigmas=gain_sigmas,
        quadrature_sigmas=quadrature_sigmas,
        out_of_bounds=out_of_bounds,
        processor_s=processor_s,
    )


@dataclass(frozen=True, slots=True)
class _Moments:
    """Which moments are called valid, and which of these are right, shape (n_moments,)."""

    valid: BoolArray
    right: BoolArray


def _first_stored(result: RunResult) -> int:
    excerpt = result.recording.excerpt
    return 0 if excerpt is None else excerpt.first_stored


def _moments(scene: Scene, paths: PathLengths, first: int) -> _Moments:
    step = scene.step
    n_samples = scene.recording.n_samples
    claimed, change_m = np.zeros(n_samples, dtype=np.bool_), np.full(n_samples, np.nan)
    claimed[first : first + paths.valid.shape[1]] = paths.valid[0]
    change_m[first : first + paths.valid.shape[1]] = paths.change_m[0]
    claimed &= np.isfinite(change_m)
    pieces = _pieces(paths)
    piece = np.zeros(n_samples, dtype=np.intp)
    if pieces is not None:
        piece[first : first + len(pieces)] = pieces
    valid, right = np.zeros_like(scene.knowable), np.zeros_like(scene.knowable)
    for moment in range(len(scene.knowable)):
        if scene.judged is not None and not scene.judged[moment]:
            continue
        span = slice(moment * step, min((moment + 1) * step + 1, n_samples))
        at = np.flatnonzero(claimed[span]) + span.start
        if len(at) < MAX_VALID * (span.stop - span.start):
            continue
        valid[moment] = True
        if piece[at[0]] != piece[at[-1]]:
            right[moment] = True  # a new piece begins: no change is claimed
            continue
        said_m = change_m[at[-1]] - change_m[at[0]]
        right[moment] = any(_agrees(said_m, true_m, scene) for true_m in _truths(scene, int(at[0]), int(at[-1])))
    return _Moments(valid, right)


def _truths(scene: Scene, first: int, last: int) -> list[float]:
    if not scene.echoes:
        return [0.0]
    strengths = [float(echo.amplitude_v[first : last + 1].max()) for echo in scene.echoes]
    return [
        float(echo.path_m[last] - echo.path_m[first])
        for echo, strength in zip(scene.echoes, strengths, strict=True)
        if strength >= EQUAL_ECHO * max(strengths)
    ]


def _agrees(said_m: float, true_m: float, scene: Scene) -> bool:
    off_m = abs(said_m - true_m)
    return bool(off_m <= OFF_WAVELENGTHS * scene.setup.radar.wavelength_m or off_m <= OFF_SHARE * abs(true_m))


def _wrong(scene: Scene, result: RunResult, moments: _Moments) -> str:
    if scene.expected == "refused":
        return "motion reported where nothing moves"
    n_valid = int(moments.valid.sum())
    n_wrong = n_valid - int(moments.right.sum())
    if n_wrong > WRONG_SHARE * n_valid:
        return f"path wrong in {n_wrong} of {n_valid} moments called valid"
    assert result.paths is not None
    return _joined_wrongly(scene, result.paths, _first_stored(result))


def _joined_wrongly(scene: Scene, paths: PathLengths, first: int) -> str:
    """Return where a path is joined over a hole with a jump that is no target's."""
    claimed = paths.valid[0] & np.isfinite(paths.change_m[0])
    piece = _pieces(paths)
    stretches = runs(claimed)
    step = scene.step
    judged = np.ones(len(claimed), dtype=np.bool_)
    if scene.judged is not None:
        each = np.repeat(scene.judged, step)[first : first + len(claimed)]
        judged[:] = False
        judged[: len(each)] = each
    for (a, b), (c, d) in itertools.pairwise(stretches):
        if not judged[b - 1 : c + 1].all():
            continue
        if piece is not None and piece[b - 1] != piece[c]:
            continue
        jumps = [
            abs(
                _off(paths, echo.path_m[first:], c, min(c + step, d))
                - _off(paths, echo.path_m[first:], max(a, b - step), b)
            )
            for echo in scene.echoes
        ]
        if min(jumps) > JUMP_WAVELENGTHS * scene.setup.radar.wavelength_m:
            return (
                f"path joined over {c - b} samples, {min(jumps) / scene.setup.radar.wavelength_m:.1f} wavelengths off"
            )
    return ""


def _off(paths: PathLengths, path_m: FloatArray, first: int, last: int) -> float:
    return float(np.median(paths.change_m[0, first:last] - path_m[first:last]))


def _pieces(paths: PathLengths) -> FloatArray | None:
    """Return the piece of each sample; None where paths have one zero throughout."""
    piece = getattr(paths, "piece", None)
    if piece is None:
        return None
    return np.asarray(piece[0] if np.ndim(piece) == 2 else piece)


def _front_end(scene: Scene, result: RunResult) -> tuple[float, float, bool]:
    if result.corrected is None or not result.corrected.channels:
        return np.nan, np.nan, False
    quality = result.corrected.channels[0]
    gain, quadrature_deg = quality.gain_ratio, quality.quadrature_error_deg
    out = (gain is not None and not GAIN_BOUNDS[0] < gain < GAIN_BOUNDS[1]) or (
        quadrature_deg is not None and abs(quadrature_deg) > QUADRATURE_BOUND_DEG
    )
    return (
        _sigmas(gain, scene.gain_ratio, quality.u_gain_ratio),
        _sigmas(quadrature_deg, scene.quadrature_error_deg, quality.u_quadrature_error_deg),
        out,
    )


def _sigmas(value: float | None, truth: float, u: float | None) -> float:
    return np.nan if value is None or not u else abs(value - truth) / u
