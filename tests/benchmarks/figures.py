"""The figures of docs/method.md, made from seeded scenes with known truth.

python3 packaging/dev.py bench figures [--output docs/figures] [--only iq_plane path_error noise fall walls bias]
"""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from unittest.mock import patch

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from benchmarks.accuracy import with_method
from benchmarks.gate.worker import setup_of_version
from benchmarks.scoring.generic import noise_bound_m, score
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.mismatch import mirrored
from benchmarks.world.generic.scene import SceneRecord, make_record
from benchmarks.world.kinds import draw as draw_modelled
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter
from support.estimates import conditioned_of, joint_of

from radargui.correction.published import PublishedSteps
from radargui.estimation.flights.estimate import DropEstimate, estimate_drop
from radargui.estimation.flights.readout import drop_motion, place_changes
from radargui.estimation.joint import JointEstimate
from radargui.estimation.select import wall_grid, walls
from radargui.estimation.select.choose import search_wall
from radargui.estimation.signals import scaled_signals
from radargui.estimation.solve.changed_problem import positions_at_bins
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult
from radargui.motion.free_flight import fall_below_apex
from radargui.physics.path_length import path_gradient, path_lengths, place_antennas
from radargui.processing.process import process
from radargui.report.plots import I_COLOUR, Q_COLOUR, RAW_COLOUR, RECEIVER_COLOURS, page_style
from radargui.restitution.joint_bounces import joint_bounces

METHODS = ("published", "ellipse", "adaptive", "joint")
MARKERS = {"published": "s", "ellipse": "^", "adaptive": "o", "joint": "D"}
COLOURS = {"published": Q_COLOUR, "ellipse": RAW_COLOUR, "adaptive": RECEIVER_COLOURS[2], "joint": I_COLOUR}
SNR_DB = (20.0, 25.0, 30.0, 35.0, 40.0, 45.0)
SNR_SEEDS = (11, 12, 13)
WIDTH_INCH = 6.3


@cache
def floor_drop() -> SceneRecord:
    """A 26 cm drop onto a floor that reflects a fifth, with strong air drag; no wall, no 1/f noise."""
    fixed = {"snr_db": 38.0, "rate_hz": 33333.0, "skew_s": 5e-6, "floor": 0.2, "wall": 0.0, "flicker": 0.0}
    return make_record(
        draw_scene(4, "physical", "drop", **fixed, drag=0.06, height_m=0.26, e=0.8, drift_m_s=0.02, n_receivers=3)
    )


@cache
def wall_drop() -> SceneRecord:
    """The same kind of drop beside a wall that reflects three hundredths."""
    fixed = {"snr_db": 40.0, "rate_hz": 33333.0, "skew_s": 5e-6, "floor": 0.2, "wall": 0.03, "flicker": 0.0}
    return make_record(
        draw_scene(6, "physical", "drop", **fixed, drag=0.005, height_m=0.26, e=0.7, drift_m_s=0.04, n_receivers=3)
    )


@cache
def floor_result(correction: str) -> RunResult:
    """What a correction makes of `floor_drop`."""
    record = floor_drop()
    return process(record.recording, with_method(record.setup, f"{correction}-exact"))


@cache
def floor_estimate() -> JointEstimate:
    """The joint estimate of `floor_drop` with all it knows."""
    return joint_of(floor_drop().recording, floor_drop().setup)


def iq_plane() -> Figure:
    """I against Q of one receiver until the first apex: as recorded, published, joint."""
    record = floor_drop()
    impacts = record.truth.impact_time_s
    first, last = record.scene.motion.motion_start_s, 0.5 * (impacts[0] + impacts[1])
    time = record.recording.time_s()
    part = (time > first) & (time < last)
    figure, panels = _sheet(1, 3, 2.35)
    raw = record.recording.volts()[:2, part]
    centre, size = raw.mean(axis=1, keepdims=True), np.sqrt(2.0) * raw.std(axis=1).mean()
    shown = [("as recorded", raw, centre[:, 0], 1.6 * size, "V")]
    for name in ("published", "joint"):
        corrected = floor_result(name).corrected
        shown.append((name, np.stack([corrected.i[0, part], corrected.q[0, part]]), np.zeros(2), 1.45, "amplitudes"))
    for axes, (title, pair, middle, half, unit) in zip(panels, shown, strict=True):
        i, q = (_thinned(row, 12) for row in pair)
        axes.plot(i, q, color=I_COLOUR, linewidth=0.4)
        axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
        axes.set(aspect="equal", title=title, xlabel=f"I / {unit}", ylabel=f"Q / {unit}")
        if unit != "V":
            turn = np.linspace(0.0, 2.0 * np.pi, 181)
            axes.plot(np.cos(turn), np.sin(turn), color="black", linewidth=0.7, linestyle=(0, (3, 3)))
    return figure


def path_error() -> Figure:
    """Error of one path length against time, each correction on its own scale, with twice its uncertainty."""
    record = floor_drop()
    time = record.recording.time_s()
    start, impacts = record.scene.motion.motion_start_s, record.truth.impact_time_s
    part = (time > start - 0.05) & (time < impacts[0] + 0.45)
    true = record.truth.path_m[0] - record.truth.path_m[0, 0]
    figure, panels = _sheet(4, 1, 4.6, sharex=True)
    for axes, name in zip(panels, METHODS, strict=True):
        paths = floor_result(name).paths
        factor, unit = (1e3, "mm") if name in ("published", "ellipse") else (1e6, "µm")
        at, error = 1e3 * (time[part] - start), factor * (paths.change_m[0] - true)[part]
        u = 2.0 * factor * paths.u_m[0, part]
        band_at, band = (_thinned(row, 150) for row in (at, u))
        at, error = (_thinned(row, 30) for row in (at, error))
        axes.fill_between(band_at, -band, band, color=COLOURS[name], alpha=0.22, linewidth=0)
        axes.plot(at, error, color=COLOURS[name], linewidth=0.7)
        for moment in impacts:
            axes.axvline(1e3 * (moment - start), color="#404040", linewidth=0.4, linestyle=":")
        largest = 1.25 * max(float(np.abs(error).max()), float(np.median(u)))
        axes.set(ylim=(-largest, largest), ylabel=f"error / {unit}", xlim=(at[0], at[-1]))
        axes.set_title(f"{name}: {np.sqrt(np.mean(error**2)):.2g} {unit} rms, band ±2u")
    panels[-1].set_xlabel("time since the release / ms; dotted: impacts")
    return figure


def noise() -> Figure:
    """3D error over the 3D noise bound against signal to noise: medians of some drops, and each of them."""
    figure, (axes,) = _sheet(1, 1, 2.9)
    for name in ("published", "adaptive", "joint"):
        ratios = np.array([[_over_bound(seed, snr, name) for snr in SNR_DB] for seed in SNR_SEEDS])
        look = {"color": COLOURS[name], "marker": MARKERS[name]}
        for row in ratios:
            axes.plot(SNR_DB, row, linestyle="", markersize=2.5, alpha=0.5, markeredgewidth=0, **look)
        axes.plot(SNR_DB, np.median(ratios, axis=0), linewidth=1.0, markersize=4.0, label=name, **look)
    axes.axhline(1.0, color="black", linewidth=0.7, linestyle=(0, (3, 3)))
    axes.set(yscale="log", xlabel="signal to noise / dB", ylabel="3D error / noise bound", xlim=(19.0, 46.0))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.legend(loc="upper left")
    return figure


def _over_bound(seed: int, snr_db: float, name: str) -> float:
    record = _noisy_drop(seed, snr_db)
    result = process(record.recording, with_method(record.setup, f"{name}-exact"))
    moving = record.recording.time_s() > record.scene.motion.motion_start_s
    gradient = path_gradient(record.truth.position_m[:, moving][:, ::50], place_antennas(record.setup))
    square = np.einsum("ran,rbn->nab", gradient, gradient)
    spread = float(np.sqrt(np.mean(np.trace(np.linalg.inv(square), axis1=1, axis2=2))))
    found = score(record, name, result, 0.0).rms_3d_mm
    return np.nan if found is None else 1e-3 * found / (spread * noise_bound_m(record))


@cache
def _noisy_drop(seed: int, snr_db: float) -> SceneRecord:
    fixed = {"rate_hz": 10000.0, "skew_s": 5e-6, "height_m": 0.20, "e": 0.75, "n_receivers": 3, "drift_m_s": 0.03}
    return make_record(draw_scene(seed, "generic", "drop", **fixed, snr_db=snr_db, amplitude_v=1.0))


def fall() -> Figure:
    """Residuals of the first fall: against a parabola of free bend, and against the fitted flight with drag."""
    record, estimate = floor_drop(), floor_estimate()
    fit = joint_bounces(estimate, record.setup)[1]
    assert fit is not None
    time, u = estimate.time_s, estimate.u_position_m
    assert estimate.position_m is not None
    assert u is not None
    part = (time > estimate.onset_s + 0.010) & (time < fit.first_end_s)
    at, height = time[part], estimate.position_m[2, part]
    parabola = np.polyval(np.polyfit(at - at[0], height, 2), at - at[0])
    law = -fall_below_apex(at - fit.apex_s[0], fit.g_m_s2, fit.drag_1_m)
    figure, (axes,) = _sheet(1, 1, 2.6)
    ms, band = 1e3 * (at - estimate.onset_s), 2e6 * u[2, part]
    ms, band = _thinned(ms, 60), _thinned(band, 60)
    axes.fill_between(ms, -band, band, color=RAW_COLOUR, alpha=0.25, linewidth=0, label="±2u of the track")
    against = _thinned(1e6 * (height - parabola), 60)
    axes.plot(ms, against, color=Q_COLOUR, linewidth=1.0, linestyle=(0, (5, 2)), label="height less best parabola")
    rest = height - law
    against = _thinned(1e6 * (rest - rest.mean()), 60)
    label = f"height less flight with drag, k = {fit.drag_1_m:.4f} ± {np.sqrt(fit.covariance[1, 1]):.4f} 1/m"
    axes.plot(ms, against, color=I_COLOUR, linewidth=1.0, label=label)
    axes.set(xlabel="time since the onset / ms", ylabel="residual / µm", xlim=(ms[0], ms[-1]))
    axes.set_title(f"true k = {record.scene.drag_1_m} 1/m")
    axes.legend(loc="best")
    return figure


def flights() -> Figure:
    """Phase over a floor that reflects more than half: of the samples as they are, and of the flights; what is left."""
    held = {"floor": 0.6, "walls": 0, "height_m": 0.25, "e": 0.6, "snr_db": 35.0, "rate_hz": 10000.0, "told": True}
    scene = draw_modelled("modelled", 55, 0, {**held, "exact": False})
    record, (setup, _) = scene.record(), setup_of_version(scene.setup)
    signals = scaled_signals(conditioned_of(record.recording, setup))
    estimate = estimate_drop(signals, setup)
    assert isinstance(estimate, DropEstimate)
    motion = drop_motion(estimate, signals, place_changes(estimate))
    figure, (above, below) = _sheet(2, 1, 4.2, sharex=True)
    moving = (motion.time_s > motion.onset_s - 0.03) & (motion.time_s < estimate.end_s)
    ms = 1e3 * (motion.time_s - motion.onset_s)
    i, q = signals.value[:2] - signals.value[:2, moving].mean(axis=1, keepdims=True)
    shown = np.unwrap(np.arctan2(q, i)[moving]) / (2.0 * np.pi)
    fringes = motion.change_m[0, moving] / setup.radar.wavelength_m
    at = _thinned(ms[moving], 2)
    above.plot(at, _thinned(shown - shown[0], 2), color=RAW_COLOUR, linewidth=0.8, label="samples about their mean")
    above.plot(at, _thinned(fringes, 2), color=I_COLOUR, linewidth=1.0, label="flights")
    above.set(ylabel="phase / fringes", xlim=(at[0], at[-1]))
    above.legend(loc="best")
    bins = estimate.model.bins
    for number, (name, colour) in enumerate((("I", I_COLOUR), ("Q", Q_COLOUR))):
        residual = estimate.at.residual[0, number]
        below.plot(1e3 * (bins.time_s - motion.onset_s), residual, ".", color=colour, markersize=2.0, label=name)
    below.set(ylim=(-5.0, 5.0), ylabel="residual / noise", xlabel="time since the onset / ms; dotted: impacts")
    for axes in (above, below):
        for moment in motion.impact_s:
            axes.axvline(1e3 * (moment - motion.onset_s), color="#404040", linewidth=0.4, linestyle=":")
    below.legend(loc="upper right")
    return figure


def wall_map() -> Figure:
    """Log evidence that one more wall brings, over its azimuth and distance: the first, coarse search."""
    record, seen = wall_drop(), []

    def watched(solution, normal, round_done, *, thorough):
        seen.append((solution, normal, search_wall(solution, normal, round_done, thorough=thorough)))
        return seen[-1][-1]

    with patch("radargui.estimation.select.choose.search_wall", watched):
        joint_of(record.recording, record.setup)
    solution, normal, search = seen[0]
    middle = positions_at_bins(solution).mean(axis=1)
    azimuth, distance_m = wall_grid.wall_grid()
    planes = wall_grid.upright_planes(middle, normal, azimuth, distance_m)
    gain = wall_grid.linearised_gains(solution, planes, lambda: None).reshape(azimuth.size, -1)
    outward = -np.array([plane.normal for plane in planes]).reshape(azimuth.size, -1, 3)[:, 0]
    degrees = np.degrees(np.arctan2(outward[:, 1], outward[:, 0])) % 360.0
    order = np.argsort(degrees)
    figure, (axes,) = _sheet(1, 1, 2.6)
    distance_cm = 1e2 * distance_m
    brightest, darkest = float(gain.min()), float(gain.max() + 0.4 * np.ptp(gain))
    picture = axes.pcolormesh(
        degrees[order], distance_cm, gain[order].T, cmap="Greys", vmin=brightest, vmax=darkest, shading="nearest"
    )
    axes.grid(visible=False)
    _mark_converged(axes, search, middle)
    true = record.scene.planes[-1]
    azimuth_deg = np.degrees(np.arctan2(-true.normal[1], -true.normal[0])) % 360.0
    place = azimuth_deg, 1e2 * (true.normal @ middle - true.distance_m)
    ring = {"markersize": 10.0, "markerfacecolor": "none", "linestyle": ""}
    axes.plot(*place, "o", markeredgecolor="white", markeredgewidth=2.8, **ring)
    axes.plot(*place, "o", markeredgecolor=I_COLOUR, markeredgewidth=1.3, label="wall of the scene", **ring)
    axes.set(xlabel="azimuth of the wall / degrees", ylabel="distance from the motion / cm")
    axes.set_xticks(range(0, 361, 60))
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)
    bar = figure.colorbar(picture, ax=axes, label="log evidence, linearised", pad=0.02)
    bar.ax.set_ylim(brightest, float(gain.max()))
    return figure


def _mark_converged(axes: Axes, search: walls.WallSearch, middle_m: FloatArray) -> None:
    """Mark where the converged walls stand, with what they gain where there is room."""
    outline, written = [withStroke(linewidth=2.6, foreground="white")], []
    for number, trial in enumerate(search.tried):
        solution, gained = trial.solution, trial.gain
        unknown = solution.problem.layout.plane_unknowns(solution.state.theta)[-1]
        away = 0.5 * (solution.problem.inputs.planes[-1].image(middle_m, unknown) - middle_m)
        at = np.degrees(np.arctan2(away[1], away[0])) % 360.0, 1e2 * float(np.linalg.norm(away))
        look = {"color": Q_COLOUR, "markeredgecolor": "white", "markeredgewidth": 0.6, "linestyle": ""}
        label = {0: "best converged", 1: "others converged"}.get(number)
        axes.plot(*at, "X", markersize=4.0 if number else 7.5, label=label, zorder=3.0 - 0.1 * number, **look)
        if all(abs(at[0] - other) > 25.0 for other in written):
            written.append(at[0])
            offset, side = ((-6, 3), "right") if at[0] > 330.0 else ((7, 3), "left")
            axes.annotate(
                f"{gained:+.0f}", at, offset, textcoords="offset points", ha=side, color=Q_COLOUR, path_effects=outline
            )


def bias() -> Figure:
    """Bias that the published splines find in the first fall, against what mirrored antennas put there."""
    record = floor_drop()
    time, receiver = record.recording.time_s(), 0
    start, hit = record.scene.motion.motion_start_s, record.truth.impact_time_s[0]
    part = (time > start) & (time < hit)
    steps = floor_result("published").corrected.steps[receiver]
    assert isinstance(steps, PublishedSteps)
    images = _mirrored_paths(record, receiver, record.truth.position_m[:, part])
    fallen = 1e3 * (record.truth.position_m[2, 0] - record.truth.position_m[2, part])
    figure, panels = _sheet(1, 2, 2.5, sharex=True)
    for axes, step, name, colour, theory in zip(
        panels, (steps.i, steps.q), "IQ", (I_COLOUR, Q_COLOUR), images, strict=True
    ):
        bias_v = step.bias[part] / record.scene.amplitude_v
        axes.plot(_thinned(fallen, 40), _thinned(theory, 40), color="black", linewidth=1.6, alpha=0.45)
        axes.plot(_thinned(fallen, 40), _thinned(bias_v, 40), color=colour, linewidth=0.9, linestyle=(0, (5, 2)))
        axes.set(xlabel="height fallen / mm", ylabel=f"bias of {name} / amplitudes")
    panels[0].set_title("grey: image theory; dashed: published")
    return figure


def _mirrored_paths(record: SceneRecord, receiver: int, place: FloatArray) -> FloatArray:
    """Return offset and once-mirrored waves in I and Q, in amplitudes: all but the direct and the twice mirrored."""
    scene, antennas = record.scene, place_antennas(record.setup)
    own, (plane,) = scene.receiving[receiver], scene.planes
    k = 2.0 * np.pi / record.setup.radar.wavelength_m
    release = np.asarray(record.setup.tracer.release_position_m)[:, None]
    change = path_lengths(place, antennas)[receiver] - path_lengths(release, antennas)[receiver]
    direct = own.amplitude(place) * np.exp(1j * (k * change + own.phase_rad))
    total = np.zeros(place.shape[1], complex)
    for antenna, rho in (
        (antennas.transmitter_m, plane.forward),
        (antennas.receivers_m[receiver], plane.backward[receiver]),
    ):
        near = np.linalg.norm(place - antenna[:, None], axis=0)
        far = np.linalg.norm(place - mirrored(antenna, plane)[:, None], axis=0)
        total += rho * near / far * np.exp(1j * k * (far - near)) * direct
    if record.setup.radar.phase_sign < 0:
        total = total.conj()
    q = own.gain * (np.sin(own.quadrature_rad) * total.real + np.cos(own.quadrature_rad) * total.imag)
    return np.stack([total.real + own.offset[0], q + own.offset[1]])


def _sheet(rows: int, columns: int, height_inch: float, *, sharex: bool = False) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(WIDTH_INCH, height_inch), layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False, sharex=sharex).ravel())


def _thinned(row: FloatArray, size: int) -> FloatArray:
    """Return means of blocks of samples, as the eye would take them."""
    return np.asarray(row[: row.size // size * size].reshape(-1, size).mean(axis=1))


def _rounded(svg: str) -> str:
    """Return a drawing with its lines' coordinates to a hundredth of a point: half the bytes."""
    lines = re.compile(r' d="[^"]*"', re.DOTALL)
    return lines.sub(lambda found: re.sub(r"\d+\.\d{3,}", lambda x: f"{float(x[0]):.2f}", found[0]), svg)


FIGURES: dict[str, Callable[[], Figure]] = {
    "iq_plane": iq_plane,
    "path_error": path_error,
    "noise": noise,
    "fall": fall,
    "flights": flights,
    "walls": wall_map,
    "bias": bias,
}


def main() -> int:
    """Make the figures and tell their sizes."""
    root = Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=root / "docs" / "figures")
    parser.add_argument("--only", nargs="+", choices=FIGURES, default=list(FIGURES))
    parser.add_argument("--format", choices=("svg", "png"), default="svg")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    for name in options.only:
        path = options.output / f"{name}.{options.format}"
        with page_style():
            made = FIGURES[name]()
            made.savefig(path, dpi=150, metadata={"Date": None} if options.format == "svg" else None)
        if options.format == "svg":
            path.write_text(_rounded(path.read_text(encoding="utf-8")), encoding="utf-8")
        print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
