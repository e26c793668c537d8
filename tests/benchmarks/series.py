"""Do the report's intervals hold: simulated series of drops with known e(v), and how often the JSON's interval has it.

The truth is that of the scene: e = e1 (v / (1 m/s))^-n and a scatter from impact to impact. The first impact's e is
its value at the exact speed of the first impact; a mean over drops that scatter around it.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from support.changed import changed

from radargui.experiment.reprocess import process_run
from radargui.model.recording import Block
from radargui.model.setup import Setup, read_setup
from radargui.processing.result_of_run import result_of_run
from radargui.report.facts import SessionFacts, provenance_of, report_facts
from radargui.report.numbers import report_document
from radargui.report.run_facts import study
from radargui.report.tables import json_bytes
from radargui.restitution.statistics import CONFIDENCE
from radargui.session.session import Session
from radargui.sources.simulated.model import SimulatedRadar
from radargui.sources.simulated.scene import Fall, contact_plane
from radargui.system.resources import default_setup_path

E1, EXPONENT, SCATTER = 0.6, 0.1, 0.004
LEAST, MOST = 0.90, 0.99
"""Share of series whose 95 % interval holds the truth."""
NOW = datetime(2026, 11, 20, 12, tzinfo=UTC)


def scene_setup(seed: int, correction: str, rate_hz: float) -> Setup:
    """Return the shipped setup with a scene of this seed, hardware and surroundings drawn anew."""
    simulation = {"seed": seed, "restitution": E1, "restitution_exponent": EXPONENT, "restitution_scatter": SCATTER}
    return changed(
        read_setup(default_setup_path()),
        simulation={**simulation, "rest_s": 0.5, "settle_s": 0.3},
        daq={"rate_hz": rate_hz, "channel_skew_s": 0.0},
        processing={"correction": correction},
    )


def document_of(setup: Setup, drops: int, folder: Path) -> dict[str, object]:
    """Record a session, process it, and return its report as its JSON says it."""
    session = Session.create(folder, setup, now=NOW)
    for run in range(drops):
        radar = SimulatedRadar(setup, run=run)
        with session.new_run(radar.digitisation, started_at=NOW.isoformat()) as writer:
            writer.write(Block(radar.samples(0, radar.n_samples or 0), 0))
        process_run(writer.path)
    runs = tuple(study(path, setup, result_of_run) for path in session.run_paths())
    facts = SessionFacts(session.info, runs, provenance_of(session, {run.name: run for run in runs}, "now"))
    session.close()
    found: dict[str, object] = json.loads(json_bytes(report_document(report_facts([facts], "now"))))
    return found


def true_first(setup: Setup) -> tuple[float, float]:
    """Return the exact speed of the first impact along the normal, and the mean e there."""
    simulation, plane = setup.simulation, contact_plane(setup)
    fall = Fall(simulation, np.array(setup.tracer.release_position_m), plane)
    first = float(fall.impact_time_s[0])
    step = 1e-5
    # second order from above the floor only
    z = [plane.height_m(fall.position_m(np.array([first - k * step]))[:, 0]) for k in (0, 1, 2)]
    speed = -(3.0 * z[0] - 4.0 * z[1] + z[2]) / (2.0 * step)
    return speed, simulation.restitution_at(speed)


def main() -> int:
    """Run the study, print its figures, and return 1 where a share lies outside of its limits."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--seed", type=int, default=int(time.time()), help="first of the seeds; else drawn from the clock"
    )
    parser.add_argument("--series", type=int, default=100)
    parser.add_argument("--drops", type=int, default=10)
    parser.add_argument("--correction", default="adaptive")
    parser.add_argument("--rate-hz", type=float, default=4000.0)
    options = parser.parse_args()
    print(f"seeds from {options.seed}, {options.correction}, {options.rate_hz:g} Hz, {options.drops} drops", flush=True)
    held: dict[str, list[bool]] = {"mean e": [], "exponent": [], "e1": []}
    away: dict[str, list[float]] = {"mean e": [], "exponent": [], "e1": []}
    impacts: list[tuple[float, float]] = []
    counts, ratios, shapes, refused = [], [], [], 0
    for seed in range(options.seed, options.seed + options.series):
        setup = scene_setup(seed, options.correction, options.rate_hz)
        with tempfile.TemporaryDirectory() as folder:
            document = document_of(setup, options.drops, Path(folder))
        speed, e_true = true_first(setup)
        mean = document["series"]["e_first_bounce"]
        counts.append(mean["n"])
        (sample,) = document["samples"]
        (power,) = (fit for fit in sample["fits"] if fit["model"] == "power")
        found = {"mean e": (mean, e_true, mean["mean"], mean["standard_error"])}
        if power["problem"]:
            refused += 1
        else:
            for name, truth, one in zip(("e1", "exponent"), (E1, EXPONENT), power["parameters"], strict=True):
                found[name] = (one, truth, one["value"], one["u"])
        for name, (one, truth, value, u) in found.items():
            held[name].append(one["interval_low"] <= truth <= one["interval_high"])
            away[name].append((value - truth) / u)
        shapes += [] if power["trend_p"] is None else [power["trend_p"] < 1.0 - CONFIDENCE]
        ratios.append(mean["consistency"]["birge_ratio"])
        marks = " ".join(f"{name} {away[name][-1]:+.2f} u" for name in found)
        print(f"{seed}: n {mean['n']}, v {speed:.4f} m/s, e {mean['mean']:.5f} ({e_true:.5f}), {marks}", flush=True)
        impacts += [
            (one["speed_before_m_s"], one["e"] - setup.simulation.restitution_at(one["speed_before_m_s"]))
            for run in document["runs"]
            for one in run["bounces"]
            if one["valid"]
        ]
    speed, difference = np.array(impacts).T
    for low, high in itertools.pairwise((0.0, 0.1, 0.15, 0.2, 0.3, 0.6, 1.2, 3.0)):
        part = difference[(speed >= low) & (speed < high)]
        if part.size > 1:
            error = part.std(ddof=1) / np.sqrt(part.size)
            print(f"e at {low:g} to {high:g} m/s: {part.mean():+.5f} ({error:.5f}), {part.size} impacts")
    status = 0
    for name, inside in held.items():
        share = float(np.mean(inside)) if inside else 0.0
        print(
            f"{name}: inside in {sum(inside)} of {len(inside)}; mean {np.mean(away[name]):+.2f} u, "
            f"standard deviation {np.std(away[name], ddof=1):.2f} u"
        )
        if not LEAST <= share <= MOST and name != "e1":
            status = 1
    print(f"drops with a valid e: {np.mean(counts):.2f} of {options.drops}; power law refused {refused} times")
    print(f"power law said not to describe the shape in {sum(shapes)} of {len(shapes)} (5 % wanted)")
    print(f"Birge ratio of e (median): {np.median(ratios):.2f}")
    return status


if __name__ == "__main__":
    sys.exit(main())
