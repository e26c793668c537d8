"""Accuracy on seeded scenes, half generic, half physical: every correction and geometry against exact truth.

python3 packaging/dev.py bench accuracy [--seed 500] [--scenes 40] [--method joint-exact] [--kind physical]
"""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np
from benchmarks.scoring.generic import Score, score
from benchmarks.world.generic.draw import MOTIONS, draw_scene
from benchmarks.world.generic.scene import SceneRecord, make_record

from radargui.model.errors import ProcessingError
from radargui.model.setup import Setup
from radargui.processing.process import process

METHODS = tuple(
    f"{correction}-{geometry}"
    for correction in ("published", "ellipse", "adaptive", "joint")
    for geometry in ("plane", "exact")
)


def with_method(setup: Setup, method: str) -> Setup:
    """Return the setup with the correction and the geometry of a method's name."""
    correction, geometry = method.split("-")
    plain = setup.model_dump(by_alias=True, exclude_unset=True)
    return Setup.model_validate({**plain, "processing": {"correction": correction, "geometry": geometry}})


def run(seeds: range, kinds: tuple[str, ...], methods: tuple[str, ...], motion: str | None) -> list[Score]:
    """Score every method on every scene; print as they come."""
    scores = []
    for seed in seeds:
        for kind in kinds:
            record = make_record(draw_scene(seed, kind, motion))
            for name in methods:
                begin = time.process_time()
                try:
                    result = process(record.recording, with_method(record.setup, name))
                except ProcessingError as error:
                    print(f"{record.scene.name:22s} {name:15s} {error}")
                    continue
                scores.append(score(record, name, result, time.process_time() - begin))
                print(_line(record, scores[-1]), flush=True)
    return scores


def _line(record: SceneRecord, one: Score) -> str:
    scene = record.scene
    made = f"{scene.snr_db:3.0f} dB {scene.rate_hz / 1e3:4.1f}k planes {len(scene.planes)} 1/f {scene.flicker:.3f}"
    return (
        f"{one.scene:22s} {one.method:15s} {made} L/bound {one.path_over_bound or np.nan:7.2f} "
        f"3D {one.rms_3d_mm or np.nan:7.4f} mm in2u {one.inside_2u or np.nan:.2f} "
        f"missed {one.missed} false {one.false} "
        f"e {_number(one.first_e_percent)} % ({_number(one.first_e_in_u)} u) g {_number(one.g_percent)} % "
        f"({_number(one.g_in_u)} u) by {one.used} {one.seconds:.1f} s"
    )


def _number(value: float | None) -> str:
    return "   -   " if value is None else f"{value:+.4f}"


def table(scores: list[Score]) -> str:
    """Return medians and worsts by method and kind; slow pendulums apart."""
    rows = []
    for method in dict.fromkeys(s.method for s in scores):
        for kind in ("generic", "physical", "pendulum"):
            part = [
                s
                for s in scores
                if s.method == method
                and (s.motion == "pendulum" if kind == "pendulum" else s.kind == kind and s.motion != "pendulum")
            ]
            if part:
                rows.append(f"{method:15s} {kind:9s} {_row(part)}")
    return "\n".join(rows)


def _row(part: list[Score]) -> str:
    def spread(values: list[float | None], digits: int) -> str:
        known = np.abs([v for v in values if v is not None])
        return "-" if known.size == 0 else f"{np.median(known):.{digits}f}/{known.max():.{digits}f}"

    inside = [s.inside_2u for s in part if s.inside_2u is not None]
    e_in, e_all = (sum(s.e_inside_2u[k] for s in part) for k in range(2))
    g = [abs(s.g_in_u) < 2.0 for s in part if s.g_in_u is not None]
    return (
        f"n {len(part)} | median/worst: L/bound {spread([s.path_over_bound for s in part], 2)}, "
        f"3D mm {spread([s.rms_3d_mm for s in part], 4)}, first e % {spread([s.first_e_percent for s in part], 4)}, "
        f"g % {spread([s.g_percent for s in part], 4)}, s {spread([s.seconds for s in part], 1)} | "
        f"missed {sum(s.missed for s in part)} false {sum(s.false for s in part)} | inside 2u: "
        f"track {np.mean(inside) if inside else np.nan:.3f}, e {e_in}/{e_all}, g {sum(g)}/{len(g)}"
    )


def main() -> int:
    """Parse the command line and run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=500, help="first seed; others give fresh scenes")
    parser.add_argument("--scenes", type=int, default=40, help="half generic, half physical")
    parser.add_argument("--kind", choices=("generic", "physical"))
    parser.add_argument("--motion", choices=tuple(dict.fromkeys(MOTIONS)))
    parser.add_argument("--method", choices=METHODS, action="append")
    options = parser.parse_args()
    kinds = (options.kind,) if options.kind else ("generic", "physical")
    seeds = range(options.seed, options.seed + -(-options.scenes // len(kinds)))
    print(table(run(seeds, kinds, tuple(options.method or METHODS), options.motion)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
