"""Calibration on laboratories with a setup that is off: a circle and a fall, twelve drops, faults.

python3 packaging/dev.py bench calibrate [--seed 4001] [--scenes 10] [--kind circle|drops|faults] [--drops 12]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from benchmarks.scoring.calibration_scenes import PLACES, Laboratory, circled, dropped, known, laboratory, truth

from radargui.calibration.calibrate import Calibrated, calibrate
from radargui.calibration.rough_fit import KnownRecording, Rough, rough_fit
from radargui.calibration.unknowns import USUAL
from radargui.model.arrays import FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.setup import Setup, moved
from radargui.physics.path_length import locate_exact, path_lengths, place_antennas

CENTRE_M = np.array([0.05, 0.03, 0.02])
SLIP_S, NEAR_S = 0.01, 0.03
U_RELEASE_M = 0.002 / 3.0**0.5


def track_error_m(setup: Setup, lab: Laboratory, path_m: FloatArray, stated_m: FloatArray, place: int) -> FloatArray:
    """Return the error of places counted from the release, (3, n), that exact paths have by the geometry alone."""
    true = place_antennas(lab.scene.setup)
    change = path_lengths(path_m, true) - path_lengths(np.array(PLACES[place])[:, None], true)
    found = locate_exact(change, place_antennas(setup), stated_m)
    return np.asarray(found - stated_m[:, None] - path_m + np.array(PLACES[place])[:, None])


def fallen(place: int) -> tuple[FloatArray, FloatArray]:
    """Return times and path of another drop from a place, shapes (60,) and (3, 60)."""
    time_s = np.linspace(0.0, 0.2, 60)
    return time_s, np.array(PLACES[place])[:, None] + np.array([[0.0], [0.0], [-0.5 * 9.81]]) * time_s**2


def rms_3d_m(error_m: FloatArray) -> float:
    """Return the root mean square distance of errors, shape (3, n)."""
    return float(np.sqrt((error_m**2).sum(axis=0).mean()))


def of_exact_antennas_m(lab: Laboratory, place: int) -> float:
    """Return the 3D error that the stated release alone makes: no calibration of the antennas goes below it."""
    _, path = fallen(place)
    return rms_3d_m(track_error_m(lab.scene.setup, lab, path, np.array(lab.places_m[place]), place))


def of_geometry(found: Calibrated, lab: Laboratory, place: int) -> tuple[float, float, float, float, float]:
    """Return what another drop shows: 3D error before and after (m), share inside 2u, error of g before and after.

    g as the mean second derivative of the fall; drag is the same in both and cancels.
    """
    time_s, path = fallen(place)
    stated = np.array(lab.places_m[place])
    values, cov = (
        dict(zip(found.calibration.names, found.calibration.values, strict=True)),
        found.calibration.covariance,
    )
    here = np.array([values.get(f"tracer.release_position_m.{a}", np.nan) for a in "xyz"])
    is_same = place == 0 and np.isfinite(here).all()
    before = track_error_m(lab.setup, lab, path, stated, place)
    base = here if is_same else stated
    after = track_error_m(found.setup, lab, path, base, place)
    variance = np.zeros_like(after)
    columns = []
    for name in found.calibration.names:
        parts = name.split(".")
        if parts[0] == "tracer":
            step = np.eye(3)["xyz".index(parts[2])] * 1e-5 * is_same
            columns.append((track_error_m(found.setup, lab, path, base + step, place) - after) / 1e-5)
            continue
        key = f"receiver[{parts[1]}].{parts[2]}" if parts[0] == "receiver" else name
        other = track_error_m(moved(found.setup, key, 1e-4), lab, path, base, place)
        columns.append((other - after) / 1e-4)
    jacobian = np.array(columns)
    variance = np.einsum("kan,kl,lan->an", jacobian, cov, jacobian)
    if not is_same:
        for axis in np.eye(3) * 1e-5:
            column = (track_error_m(found.setup, lab, path, base + axis, place) - after) / 1e-5
            variance = variance + (U_RELEASE_M * column) ** 2
    inside = float((np.abs(after[:, 5:]) <= 2.0 * np.sqrt(variance[:, 5:])).mean())
    bends = [2.0 * np.polyfit(time_s, error[2], 2)[0] / 9.81 for error in (before, after)]
    return rms_3d_m(before), rms_3d_m(after), inside, abs(bends[0]), abs(bends[1])


def compare(found: Calibrated, lab: Laboratory) -> tuple[float, float, float, float, float]:
    """Return what the antenna values are off.

    The worst angle (deg), the worst distance (m), the share inside 2u, the root mean square and the largest of the
    errors over u.
    """
    calibration = found.calibration
    u = np.sqrt(np.diag(calibration.covariance))
    worst, ratios = {"deg": 0.0, "m": 0.0}, []
    for name, value, own in zip(calibration.names, calibration.values, u, strict=True):
        true = truth(lab, name)
        if true is not None:
            unit = name.rsplit("_", 1)[1]
            worst[unit] = max(worst[unit], abs(value - true))
            ratios.append(abs(value - true) / own)
    sizes = np.array(ratios)
    return worst["deg"], worst["m"], float((sizes <= 2.0).mean()), float(np.sqrt((sizes**2).mean())), float(sizes.max())


def recordings(lab: Laboratory, kind: str, drops: int, folder: Path) -> list[KnownRecording]:
    """Return what is calibrated with."""
    if kind == "circle":
        record, trajectory = circled(lab, folder, centre_m=CENTRE_M)
        return [known(record, trajectory, lab.places_m[0]), known(dropped(lab, 0, 1), None, lab.places_m[1])]
    return [known(dropped(lab, n, n % 3), None, lab.places_m[n % 3]) for n in range(drops)]


def run(seeds: range, kind: str, drops: int, workers: int, held: dict[str, object]) -> None:
    """Print a line a seed and a summary."""
    rows = []
    for seed in seeds:
        lab = laboratory(seed, **held)
        with tempfile.TemporaryDirectory() as folder:
            given = recordings(lab, kind, drops, Path(folder))
            begin = time.perf_counter()
            try:
                found = calibrate(given, lab.setup, workers=workers)
            except ProcessingError as error:
                print(f"{seed} refused: {error}", flush=True)
                continue
        lasted = time.perf_counter() - begin
        angle, distance, values_inside, rms_u, worst_u = compare(found, lab)
        row = (angle, distance, values_inside, *of_geometry(found, lab, 0), lasted)
        rows.append(row)
        print(
            f"{seed} walls {lab.scene.facts['walls']}: angle {row[0]:.3f} deg, distance {1e3 * row[1]:.2f} mm, "
            f"inside 2u {row[2]:.2f} (error over u: rms {rms_u:.2f}, worst {worst_u:.2f}); "
            f"3D {1e3 * row[3]:.2f} -> {1e3 * row[4]:.3f} mm "
            f"(exact antennas {1e3 * of_exact_antennas_m(lab, 0):.3f}), inside 2u {row[5]:.2f}; "
            f"g {100 * row[6]:.3f} -> {100 * row[7]:.4f} %; {lasted:.0f} s; {found.calibration.verdict}",
            flush=True,
        )
    if rows:
        table = np.array(rows)
        print(f"median {np.round(np.median(table, axis=0), 5)}\nworst {np.round(table.max(axis=0), 5)}")
        print(f"mean inside 2u: values {table[:, 2].mean():.3f}, track {table[:, 5].mean():.3f}; {len(rows)} seeds")


def slipped(one: KnownRecording, receiver: int, time_s: float) -> KnownRecording:
    """Return a recording in which a receiver's phase makes a turn too many within `SLIP_S`."""
    recording = one.recording
    raw = recording.raw.astype(float)
    pair = raw[2 * receiver : 2 * receiver + 2]
    middle = 0.5 * (pair.max(axis=1) + pair.min(axis=1))[:, None]
    turn = np.clip((np.arange(raw.shape[1]) / recording.digitisation.sample_rate_hz - time_s) / SLIP_S, 0.0, 1.0)
    i, q = pair - middle
    turned = (i + 1j * q) * np.exp(2j * np.pi * turn)
    raw[2 * receiver : 2 * receiver + 2] = middle + np.stack([turned.real, turned.imag])
    if np.issubdtype(recording.raw.dtype, np.integer):
        raw = np.round(raw)
    return replace(one, recording=replace(recording, raw=raw.astype(recording.raw.dtype)))


def unharmed(sound: Rough, found: Rough) -> bool:
    """Return whether the paths of the fall are those of a sound recording, but for the moment of the fault itself."""
    (before, after) = (one.by_paths[1].measured for one in (sound, found))
    moved = [
        np.interp(before.time_s, after.time_s, b) - a for a, b in zip(before.change_m, after.change_m, strict=True)
    ]
    return bool((np.abs(moved) < sound.by_paths[1].wavelength_m / 8.0).mean() > 0.98)


def run_faults(seeds: range, held: dict[str, object]) -> None:
    """Swap two receivers, mirror the azimuths, or lose a fringe of the fall, one a seed, and see whether it is said.

    Of laboratories without a fault that are refused, or lose a fringe by themselves, others are taken.
    """
    right, seed, count = 0, seeds.start - 1, 0
    while count < len(seeds):
        seed += 1
        rng, lab = np.random.default_rng([seed, 17]), laboratory(seed, **held)
        receivers, setup = list(lab.setup.receiver), lab.setup
        with tempfile.TemporaryDirectory() as folder:
            given = recordings(lab, "circle", 0, Path(folder))
            try:
                sound = rough_fit(given, setup, USUAL)
            except ProcessingError as error:
                print(f"{seed} left out: {error}", flush=True)
                continue
            if sound.slips:
                print(f"{seed} left out: {sound.slips}", flush=True)
                continue
            count += 1
            fault, receiver, time_s = ("swapped", "mirrored", "slip")[rng.integers(3)], 0, 0.0
            if fault == "swapped":
                a, b = sorted(rng.choice(3, 2, replace=False))
                receivers[a], receivers[b] = receivers[b], receivers[a]
                words = f"receivers {a + 1} and {b + 1} are swapped"
            elif fault == "mirrored":
                receivers = [x.model_copy(update={"azimuth_deg": -x.azimuth_deg}) for x in receivers]
                words = "(mirror image)"
            else:
                receiver, time_s = int(rng.integers(3)), float(rng.uniform(0.38, 0.47))
                given[1] = slipped(given[1], receiver, time_s)
                words = f"receiver {receiver + 1}, {time_s:.3f} s"
            setup = setup.model_copy(update={"receiver": tuple(receivers)})
            try:
                found = rough_fit(given, setup, USUAL)
                slips = found.slips
                said = "; ".join(f"recording {n + 1}, receiver {k + 1}, {t:.3f} s" for n, k, t in slips)
                near = [abs(t - time_s) < NEAR_S for _, _, t in slips]
                is_right = fault == "slip" and near == [True] and slips[0][:2] == (1, receiver)
                if fault == "slip" and not slips and unharmed(sound, found):
                    said, is_right = "the other receivers told the count: its paths are as without", True
            except ProcessingError as error:
                said, is_right = error.message, error.message.endswith(words)
        right += is_right
        print(f"{seed} {words}: {'yes' if is_right else 'NO'} ({said})", flush=True)
    print(f"recognised {right} of {count}")


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=4001)
    parser.add_argument("--scenes", type=int, default=10)
    parser.add_argument("--kind", choices=("circle", "drops", "faults"), default="circle")
    parser.add_argument("--drops", type=int, default=12)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--hold", nargs="*", default=["snr_db=36", "rate_hz=5000"])
    options = parser.parse_args()
    held: dict[str, object] = {name: float(x) for name, _, x in (one.partition("=") for one in options.hold)}
    seeds = range(options.seed, options.seed + options.scenes)
    if options.kind == "faults":
        run_faults(seeds, held)
    else:
        run(seeds, options.kind, options.drops, options.workers, held)


if __name__ == "__main__":
    main()
