"""Scores of a result against the truth of its laboratory scene, from the tables that any reader of them gets."""

from __future__ import annotations

import csv
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.world.scene import Record
from numpy.typing import NDArray

from radargui.model.result import RunResult
from radargui.report.tables import write_tables

Array = NDArray[np.float64]

SEEN_M_S, NEAR_END_S, SAME_S = 0.15, 0.015, 0.003
"""A rebound slower than this, or that late, need not be found; times closer than this are one impact."""
POOLED = 500
"""Times of a scene that count where scenes are pooled: each scene as much as any other."""
LEAST_U_M = 1e-12
WORST_RATIO = 2.5
"""rms(error) / rms(u) above which a scene has to warn."""
FAR_M, FAR_U = 1e-3, 3.0
"""A place is far off where a coordinate's error is above both: a millimetre, and so many (combined) u."""
WRONG_E_U = 5.0
"""A coefficient is wrong that is farther off, in (combined) u: honest ones are so once in two million."""
FAR_SHARE = 0.02
"""A track with more of its valid motion far off is wrong: 20 to 100 ms of the motions here."""


@dataclass(frozen=True)
class Figure:
    """One estimated number: relative error in percent, and the error in units of its u, statistical and combined."""

    error_percent: float
    in_u: float
    in_combined: float | None


@dataclass(frozen=True)
class Score:
    """One estimate of one scene; None or empty where there is no such figure.

    Attributes
    ----------
    leaning
        Whether the floor leans.
    rms_3d_mm
        Over the motion.
    inside_2u, inside_2u_combined
        Share of the coordinates within 2u.
    error_over_u, error_over_u_combined
        |error| / u of every coordinate at times evenly over the motion, shape (n,).
    ratio, ratio_combined
        rms(error) / rms(u).
    largest_over_u
        Largest |error| / u of a coordinate over the motion, u combined where there is one.
    known_share, far_share
        Share of the motion that is valid, and share of that which is far off.
    e
        Of each impact that is valid and really happened, in time order; `first_e` where the first is among them.
    false_fall
        Whether g is told of a motion in which nothing falls freely.
    seconds
        Of processor time.
    baseless_e
        How many coefficients are told, as valid, of what is no impact on a floor.
    """

    scene: str
    stated: str
    snr_db: float
    leaning: bool
    status: str
    used: str
    rms_3d_mm: float | None
    inside_2u: float | None
    inside_2u_combined: float | None
    error_over_u: Array | None
    error_over_u_combined: Array | None
    ratio: float | None
    ratio_combined: float | None
    largest_over_u: float | None
    known_share: float | None
    far_share: float | None
    missed: int
    false: int
    e: tuple[Figure, ...]
    first_e: Figure | None
    g: Figure | None
    warnings: tuple[str, ...]
    seconds: float
    motion: str = "drop"
    false_fall: bool = False
    baseless_e: int = 0

    @property
    def worst_e_in_u(self) -> float | None:
        """The largest |error| / u of a coefficient, u combined where there is one."""
        sizes = [abs(one.in_u if one.in_combined is None else one.in_combined) for one in self.e]
        return max(sizes, default=None)

    @property
    def wrong_e(self) -> bool:
        """Whether a result called ok tells a coefficient that is far off or of no impact, whatever was said of it."""
        far = self.worst_e_in_u is not None and self.worst_e_in_u > WRONG_E_U
        return self.status == "ok" and (far or self.baseless_e > 0)

    @property
    def wrong(self) -> bool:
        """Whether a part that matters of a track called ok is far off, whatever was said of it."""
        return self.status == "ok" and self.far_share is not None and self.far_share > FAR_SHARE

    @property
    def silent(self) -> bool:
        """Whether the uncertainty is too small by far, or a motion that is no drop or its e wrong, and nothing said."""
        ratio = self.ratio if self.ratio_combined is None else self.ratio_combined
        small = ratio is not None and ratio > WORST_RATIO
        return (small or (self.motion != "drop" and (self.wrong or self.wrong_e))) and not self.warnings


def score(record: Record, result: RunResult, seconds: float) -> Score:
    """Write the result's tables, read them, compare."""
    with tempfile.TemporaryDirectory() as name:
        write_tables(result, Path(name))
        track = _table(Path(name, "track.csv"))
        with Path(name, "bounces.csv").open(newline="", encoding="utf-8") as file:
            bounces = list(csv.DictReader(file))
        document = json.loads(Path(name, "result.json").read_text(encoding="utf-8"))
    e, found_s = _restitution(record, bounces)
    told_s = [float(row["time_s"]) for row in bounces if row["valid"] == "1"]
    drop, end_s = record.scene.drop, record.scene.drop.duration_s - NEAR_END_S
    seen = [one.time_s for one in drop.impacts if one.after_m_s > SEEN_M_S and one.time_s < end_s]
    first = drop.impacts[0].time_s if drop.impacts else None
    fall = document["free_fall"]
    has_g = fall is not None and fall["g_m_s2"] is not None
    return Score(
        scene=record.scene.name,
        stated=record.scene.stated,
        snr_db=record.scene.snr_db,
        leaning=bool(record.scene.facts["tilt"]),
        status=document["status"],
        used=str(document["correction_used"]),
        **_position(record, track),
        missed=sum(bool(np.abs(found_s - time).min(initial=1.0) > SAME_S) for time in seen),
        false=sum(bool(np.abs(record.truth.impact_time_s - time).min(initial=1.0) > SAME_S) for time in found_s),
        e=tuple(e.values()),
        first_e=None if first is None else e.get(first),
        g=_gravity(record, document) if has_g and record.scene.falls else None,
        warnings=tuple(document["warnings"] or ()),
        seconds=seconds,
        motion=record.scene.motion,
        false_fall=has_g and not record.scene.falls,
        baseless_e=sum(bool(np.abs(record.truth.impact_time_s - time).min(initial=1.0) > SAME_S) for time in told_s),
    )


def _table(path: Path) -> dict[str, Array]:
    with path.open(encoding="utf-8") as file:
        header = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",", ndmin=2)
    return dict(zip(header, rows.T, strict=True)) if rows.size else {}


def _position(record: Record, track: dict[str, Array]) -> dict[str, Any]:
    names = ("inside_2u", "error_over_u", "ratio")
    out: dict[str, Any] = dict.fromkeys(("rms_3d_mm", *names, *(f"{name}_combined" for name in names)))
    out |= dict.fromkeys(("largest_over_u", "known_share", "far_share"))
    if "x_m" not in track:
        return out
    moving = np.arange(record.truth.position_m.shape[1]) >= record.scene.drop.start_s * record.scene.converter.rate_hz
    known = moving & (track["valid"] == 1)
    out["known_share"] = float(known.sum() / moving.sum())
    if not known.any():
        return out
    error = np.array([track[f"{axis}_m"] for axis in "xyz"])[:, known] - record.truth.position_m[:, known]
    out["rms_3d_mm"] = 1e3 * float(np.sqrt((error**2).sum(axis=0).mean()))
    chosen = np.linspace(0, error.shape[1] - 1, POOLED).astype(int)
    told = np.zeros_like(error)
    for end in ("", "_combined"):
        u = np.array([track[f"u{axis}{end}_m"] for axis in "xyz"])[:, known]
        if np.isfinite(u).all():
            out[f"inside_2u{end}"] = float((np.abs(error) < 2.0 * u).mean())
            out[f"error_over_u{end}"] = (np.abs(error) / np.maximum(u, LEAST_U_M))[:, chosen].ravel()
            out[f"ratio{end}"] = float(np.sqrt((error**2).mean() / max((u**2).mean(), LEAST_U_M**2)))
            told = u  # combined, where there is one
    out["largest_over_u"] = float((np.abs(error) / np.maximum(told, LEAST_U_M)).max())
    out["far_share"] = float((np.abs(error) > np.maximum(FAR_M, FAR_U * told)).any(axis=0).mean())
    return out


def _restitution(record: Record, bounces: list[dict[str, str]]) -> tuple[dict[float, Figure], Array]:
    """Return the figures of e by true time of impact, and the times found."""
    found_s = np.array([float(row["time_s"]) for row in bounces])
    out = {}
    for impact in record.scene.drop.impacts:
        for row, time_s in zip(bounces, found_s, strict=True):
            if row["valid"] == "1" and impact.after_m_s > 0.0 and abs(impact.time_s - time_s) < SAME_S:
                out[impact.time_s] = _figure(
                    float(row["e"]), impact.e, float(row["u_e"]), _number(row.get("u_e_combined"))
                )
                break
    return out, found_s


def _gravity(record: Record, document: dict[str, Any]) -> Figure:
    """Compare the acceleration measured with the true one, which buoyancy is part of."""
    fall = document["free_fall"]
    combined = ((document.get("uncertainty_budget") or {}).get("g_m_s2") or {}).get("combined")
    return _figure(fall["g_m_s2"], record.scene.body.acceleration_m_s2, fall["u_g_m_s2"], combined)


def _figure(value: float, truth: float, u: float, combined: float | None) -> Figure:
    error = value - truth
    return Figure(100.0 * error / truth, error / u, None if combined is None else error / combined)


def _number(cell: str | None) -> float | None:
    value = float(cell) if cell else float("nan")
    return value if np.isfinite(value) else None
