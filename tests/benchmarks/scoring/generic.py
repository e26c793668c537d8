"""Scores of a result against the truth of its scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.generic.motion import GRAVITY_M_S2
from benchmarks.world.generic.scene import SceneRecord

from radargui.model.result import Bounces, RunResult

_SEEN_M_S, _NEAR_END_S, _SAME_S = 0.15, 0.015, 0.003


@dataclass(frozen=True)
class Score:
    """One estimate of one scene; None where the scene or the method has no such figure."""

    scene: str
    kind: str
    method: str
    motion: str
    path_over_bound: float | None
    rms_3d_mm: float | None
    inside_2u: float | None
    missed: int
    false: int
    first_e_percent: float | None
    first_e_in_u: float | None
    e_inside_2u: tuple[int, int]
    g_percent: float | None
    g_in_u: float | None
    used: str  # the correction that stood in the end
    seconds: float  # of processor time


def noise_bound_m(record: SceneRecord) -> float:
    """Return the noise bound of path length at 2 kHz bandwidth."""
    scene = record.scene
    ratio = 10.0 ** (-scene.snr_db / 20.0) / np.sqrt(2.0) * np.sqrt(min(1.0, 4000.0 / scene.rate_hz))
    return float(scene.setup.radar.wavelength_m / (2.0 * np.pi) * ratio)


def score(record: SceneRecord, method: str, result: RunResult, seconds: float) -> Score:
    """Compare a result with the truth over the moving part."""
    scene = record.scene
    time_s = record.recording.time_s()
    moving = time_s > scene.motion.motion_start_s
    path = rms = inside = None
    if result.paths is not None:
        wrong = result.paths.change_m - (record.truth.path_m - record.truth.path_m[:, :1])
        wrong = np.where(result.paths.valid, wrong, np.nan)[:, moving]
        path = float(np.sqrt(np.nanmean(wrong**2))) / noise_bound_m(record)
    if result.track is not None and result.track.valid.any():
        known = moving & result.track.valid
        error = (result.track.position_m - record.truth.position_m)[:, known]
        rms = 1e3 * float(np.sqrt(np.mean((error**2).sum(axis=0))))
        inside = float((np.abs(error) < 2.0 * result.track.u_position_m[:, known]).mean())
    bounces = result.bounces
    found_s = np.array([impact.time_s for impact in bounces.impacts])
    last = time_s[-1] - _NEAR_END_S
    seen = [i for i in scene.motion.impacts if i.after_m_s[2] > _SEEN_M_S and i.time_s < last]
    missed = sum(bool(np.abs(found_s - i.time_s).min(initial=1.0) > _SAME_S) for i in seen)
    true_times = record.truth.impact_time_s
    false = sum(bool(np.abs(true_times - t).min(initial=1.0) > _SAME_S) for t in found_s)
    errors = _restitution_errors(record, bounces)
    fall = bounces.free_fall
    return Score(
        scene.name,
        scene.kind,
        method,
        scene.name.split("-")[1],
        path,
        rms,
        inside,
        missed,
        false,
        100.0 * errors[0][0] if errors else None,
        errors[0][1] if errors else None,
        (sum(abs(r) < 2.0 for _, r in errors), len(errors)),
        None if fall is None else 100.0 * (fall.g_m_s2 / GRAVITY_M_S2 - 1.0),
        None if fall is None else (fall.g_m_s2 - GRAVITY_M_S2) / fall.u_g_m_s2,
        result.corrected.method if result.corrected is not None else result.status,
        seconds,
    )


def _restitution_errors(record: SceneRecord, bounces: Bounces) -> list[tuple[float, float]]:
    """Return the relative error of e and its error in u of each valid bounce that really happened."""
    out = []
    for bounce in bounces.impacts:
        for impact in record.scene.motion.impacts:
            if abs(impact.time_s - bounce.time_s) < _SAME_S and bounce.valid:
                e = float(-impact.after_m_s[2] / impact.before_m_s[2])
                out.append((bounce.e / e - 1.0, (bounce.e - e) / bounce.u_e))
                break
    return out
