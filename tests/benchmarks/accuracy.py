"""Accuracy on seeded scenes: one line a scene and method, one table at the end.

Run from the project's folder: python -m benchmarks.accuracy --seed 500 --scenes 40 (with tests/ on the path).
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable

import numpy as np
from benchmarks.scenes.draw import draw_scene
from benchmarks.scenes.scene import SceneRecord, make_record
from benchmarks.score import Score, score

from radargui.correction.adaptive.estimate import estimate_adaptive
from radargui.correction.estimate import MotionEstimate
from radargui.correction.joint.estimate import estimate_joint
from radargui.model.bounce import Bounces
from radargui.model.errors import ProcessingError
from radargui.restitution.joint_bounces import joint_bounces

Method = Callable[[SceneRecord], tuple[MotionEstimate, Bounces | None]]


def _joint(record: SceneRecord) -> tuple[MotionEstimate, Bounces | None]:
    estimate = estimate_joint(record.recording, record.setup)
    return estimate, joint_bounces(estimate, record.setup)[0]


def _adaptive(record: SceneRecord) -> tuple[MotionEstimate, Bounces | None]:
    return estimate_adaptive(record.recording, record.setup), None


METHODS: dict[str, Method] = {"adaptive": _adaptive, "joint": _joint}


def run(seeds: range, kinds: tuple[str, ...], methods: tuple[str, ...], motion: str | None) -> list[Score]:
    """Score every method on every scene; print as they come."""
    scores = []
    for seed in seeds:
        for kind in kinds:
            record = make_record(draw_scene(seed, kind, motion))
            for name in methods:
                begin = time.process_time()
                try:
                    estimate, bounces = METHODS[name](record)
                except ProcessingError as error:
                    print(f"{record.scene.name:22s} {name:9s} {error}")
                    continue
                scores.append(score(record, estimate, bounces, time.process_time() - begin))
                print(_line(record, scores[-1]), flush=True)
    return scores


def _line(record: SceneRecord, one: Score) -> str:
    scene = record.scene
    made = f"{scene.snr_db:3.0f} dB {scene.rate_hz / 1e3:4.1f}k planes {len(scene.planes)} 1/f {scene.flicker:.3f}"
    return (
        f"{one.scene:22s} {one.method:9s} {made} L/bound {one.path_over_bound:7.2f} "
        f"3D {one.rms_3d_mm or np.nan:7.4f} mm in2u {one.inside_2u or np.nan:.2f} "
        f"missed {one.missed} false {one.false} "
        f"e {_number(one.first_e_percent)} % ({_number(one.first_e_in_u)} u) g {_number(one.g_percent)} % "
        f"({_number(one.g_in_u)} u) chi2 {one.chi_square:.2f} {one.seconds:.1f} s"
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
                rows.append(f"{method:9s} {kind:9s} {_row(part)}")
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
    parser.add_argument("--motion", choices=("drop", "circle", "pendulum", "bed"))
    parser.add_argument("--method", choices=tuple(METHODS), action="append")
    options = parser.parse_args()
    kinds = (options.kind,) if options.kind else ("generic", "physical")
    seeds = range(options.seed, options.seed + -(-options.scenes // len(kinds)))
    print(table(run(seeds, kinds, tuple(options.method or METHODS), options.motion)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
