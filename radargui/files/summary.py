"""The summary of a run: the few figures that run lists show."""

import json
import math
from typing import Any

from radargui import __version__
from radargui.files import hdf5
from radargui.model.result import RunResult

_VERDICTS = ("rejected", "usable", "good")


def summarise(result: RunResult) -> dict[str, object]:
    """Return the figures of a run's first bounce and first fall; None where there is none or it is not valid.

    Parameters
    ----------
    result
        What the run gave.

    Returns
    -------
    dict
        `status`, `reason`, `drop_height_m`, `impact_speed_m_s`, `e`, `u_e`, `u_e_combined`, `g_m_s2`, `u_g_m_s2`,
        `u_g_combined_m_s2` (combined: with what calibration and sphere leave open; else statistical), `correction`,
        `geometry`, `version`, `n_bounces` (all impacts), `verdict` (the worst receiver's), `preliminary` (see
        `RunResult`), `from_rest` (whether the rest before the motion was recorded). JSON can hold it.
    """
    bounce = next((bounce for bounce in result.bounces.impacts[:1] if bounce.valid), None)
    fall, budget = result.bounces.free_fall, result.uncertainty_budget
    corrected, track = result.corrected, result.track
    verdicts = {channel.verdict for channel in corrected.channels} if corrected else set()
    return {
        "status": result.status,
        "reason": result.reason,
        "drop_height_m": _finite(fall.drop_height_m) if fall else None,
        "impact_speed_m_s": _finite(bounce.speed_before_m_s) if bounce else None,
        "e": _finite(bounce.e) if bounce else None,
        "u_e": _finite(bounce.u_e) if bounce else None,
        "u_e_combined": _finite(bounce.u_e_combined) if bounce else None,
        "g_m_s2": _finite(fall.g_m_s2) if fall else None,
        "u_g_m_s2": _finite(fall.u_g_m_s2) if fall else None,
        "u_g_combined_m_s2": budget.g_m_s2.combined if fall and budget else None,
        "correction": corrected.method if corrected else result.setup.processing.correction,
        "geometry": track.geometry if track else result.setup.processing.geometry,
        "version": __version__,
        "n_bounces": len(result.bounces.impacts),
        "verdict": next((verdict for verdict in _VERDICTS if verdict in verdicts), None),
        "preliminary": result.preliminary,
        "from_rest": result.segment is not None and result.segment.has_rest,
    }


def summary_in(results: Any) -> dict[str, object]:
    """Return the summary stored in a group of results; empty where there is none."""
    summary = json.loads(hdf5.text(results.attrs, "summary") or "null")
    return summary if isinstance(summary, dict) else {}


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
