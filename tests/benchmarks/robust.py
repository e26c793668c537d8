"""Right or refused: seeded one-receiver scenes, garbage and broken channels; what can be known is fixed beforehand."""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import TypeVar

import numpy as np
from benchmarks.scoring.broken import DropJudgement, judge_drop
from benchmarks.scoring.budget import timed, with_correction
from benchmarks.scoring.one_receiver import Judgement, judge
from benchmarks.world.broken.drops import BROKEN, WHOLE, drop_setup, make_drop
from benchmarks.world.broken.garbage import GARBAGE, make_garbage
from benchmarks.world.broken.reflecting import make_scene_drop
from benchmarks.world.one_receiver.generator import KINDS, make_scene

CORRECTIONS = ("adaptive", "ellipse", "published", "none")
GARBAGE_S = 3.0
FOUR_RECEIVERS_EVERY = 3
"""One drop in so many has a fourth receiver."""
MISMATCHES = ("none", "generic", "physical")
"""Of the drops, in turn: a clean echo, smooth bias and amplitude, a floor that reflects."""

Item = TypeVar("Item")
Found = TypeVar("Found")


def spread(run: Callable[[Item], Found], items: list[Item], workers: int) -> Iterator[Found]:
    """Yield what each item gives, in order; with one worker in this process."""
    if workers == 1:
        yield from map(run, items)
        return
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(run, items)


def run_scene(item: tuple[int, str | None, str], seed: int, limit_s: float) -> tuple[str, str, str, str, Judgement]:
    """Return name, kind, what is expected, correction and judgement of one scene."""
    number, kind, correction = item
    scene = make_scene(seed, number, kind)
    result, processor_s = timed(scene.recording, with_correction(scene.setup, correction), limit_s)
    if isinstance(result, str):
        judgement = Judgement(result, processor_s=processor_s)
    else:
        judgement = judge(scene, result, processor_s)
    return scene.name, scene.kind, scene.expected, correction, judgement


def run_garbage(item: tuple[str, int], limit_s: float) -> tuple[str, str, str, float]:
    """Return kind, status, reason and processor time of one recording of garbage."""
    kind, seed = item
    result, processor_s = timed(make_garbage(seed, kind), drop_setup(3), limit_s)
    status, reason = (result, "") if isinstance(result, str) else (result.status, result.reason)
    return kind, status, reason, processor_s


def run_drop(item: tuple[str, int, int, str], limit_s: float) -> tuple[str, str, DropJudgement]:
    """Return name, kind and judgement of one drop."""
    kind, seed, n_receivers, mismatch = item
    if mismatch == "none":
        drop = make_drop(seed, kind, n_receivers)
    else:
        drop = make_scene_drop(seed, kind, n_receivers, mismatch)
    result, processor_s = timed(drop.recording, drop.setup, limit_s)
    return drop.name, kind, judge_drop(drop, result, processor_s)


def scenes(options: argparse.Namespace) -> int:
    """Print the one-receiver scenes; return how many are silently wrong."""
    items = [
        (number, options.kind, correction) for number in range(options.scenes) for correction in options.correction
    ]
    rows = []
    for row in spread(partial(run_scene, seed=options.seed, limit_s=options.limit_s), items, options.workers):
        rows.append(row)
        if options.verbose:
            _tell(row)
    _table(rows, options.correction)
    return sum(bool(row[4].wrong) for row in rows)


def _tell(row: tuple[str, str, str, str, Judgement]) -> None:
    name, _, expected, correction, one = row
    outcome = f"WRONG: {one.wrong}" if one.wrong else "right" if one.right else f"{one.status} {one.reason[:70]}"
    front_end = f"gain {one.gain_sigmas:.1f} u, quadrature {one.quadrature_sigmas:.1f} u"
    share = f"valid {one.valid_share:.2f}, right {one.right_share:.2f}"
    print(
        f"{name:18} {correction:9} {expected:7} {one.processor_s:5.1f} s  {share}, {front_end}  {outcome}", flush=True
    )


def _table(rows: list[tuple[str, str, str, str, Judgement]], corrections: Iterable[str]) -> None:
    for correction in corrections:
        of_it = [row for row in rows if row[3] == correction]
        heads = f"{'kind':15}{'scenes':>7}{'knowable':>9}{'right':>6}{'wrong':>6}{'refused':>8}{'no answer':>10}"
        print(f"\n{correction}\n{heads}")
        for kind in sorted({row[1] for row in of_it}, key=list(KINDS).index):
            _line(kind, [(row[2], row[4]) for row in of_it if row[1] == kind])
        _line("all", [(row[2], row[4]) for row in of_it])
        _summary(correction, [(row[2], row[4]) for row in of_it])


def _line(kind: str, found: list[tuple[str, Judgement]]) -> None:
    knowable = sum(expected == "ok" for expected, _ in found)
    right = sum(one.right for _, one in found)
    wrong = sum(bool(one.wrong) for _, one in found)
    refused = sum(one.status in ("rejected", "no_motion") or one.status.startswith("raised") for _, one in found)
    none = sum(one.status.startswith(("crashed", "out of time")) for _, one in found)
    print(f"{kind:15}{len(found):7}{knowable:9}{right:6}{wrong:6}{refused:8}{none:10}")


def _summary(correction: str, found: list[tuple[str, Judgement]]) -> None:
    judged = [one for _, one in found]
    knowable = sum(expected == "ok" for expected, _ in found)
    right = sum(one.right for one in judged)
    told = [one for one in judged if one.status == "ok" and np.isfinite(one.gain_sigmas + one.quadrature_sigmas)]
    inside = [one.gain_sigmas <= 2.0 and one.quadrature_sigmas <= 2.0 for one in told]
    times_s = [one.processor_s for one in judged]
    wrong = sum(bool(one.wrong) for one in judged)
    bounds = sum(one.out_of_bounds for one in judged)
    refused_valid = sum(one.valid_though_refused for one in judged)
    print(
        f"{correction}: silently wrong {wrong} of {len(judged)}, "
        f"knowable right {right} of {knowable} ({100.0 * right / max(knowable, 1):.0f} %); "
        f"gain and quadrature inside 2 u in {sum(inside)} of {len(inside)}, out of bounds {bounds}; "
        f"valid though refused {refused_valid}; "
        f"processor time median {np.median(times_s):.1f} s, longest {max(times_s):.1f} s"
    )


def garbage(options: argparse.Namespace) -> int:
    """Print the verdicts on garbage; return how many are ok or without a verdict."""
    kinds = [options.kind] if options.kind in GARBAGE else list(GARBAGE)
    items = [(kind, options.seed + number) for kind in kinds for number in range(options.repeats)]
    print(f"\n{'garbage, three receivers':28}{'processor time':>15}  verdict")
    bad = 0
    for kind, status, reason, processor_s in spread(
        partial(run_garbage, limit_s=options.limit_s), items, options.workers
    ):
        failed = status != "rejected" and status != "no_motion" and not status.startswith("raised")
        bad += failed
        mark = "WRONG " if failed else "LATE " if processor_s > GARBAGE_S else ""
        print(f"{kind:28}{processor_s:13.1f} s  {mark}{status} {reason[:80]}", flush=True)
    print(f"garbage: {bad} of {len(items)} ok or without a verdict")
    return bad


def broken(options: argparse.Namespace) -> int:
    """Print the drops with broken channels, and as many sound ones; return how many say something wrong."""
    groups = [(options.kind,)] if options.kind in (*BROKEN, WHOLE) else [BROKEN, (WHOLE,)]
    items = []
    for kinds, number in itertools.product(groups, range(options.drops)):
        turn, place = divmod(number, len(kinds))
        n_receivers = 4 if (number + turn) % FOUR_RECEIVERS_EVERY == 0 else 3
        mismatch = MISMATCHES[number // 3 % len(MISMATCHES)]
        items.append((kinds[place], 1000 * options.seed + number, n_receivers, mismatch))
    print(f"\n{'drop':42}{'processor time':>15}  outcome")
    rows = []
    for name, kind, one in spread(partial(run_drop, limit_s=options.limit_s), items, options.workers):
        rows.append((kind, one))
        faults = [f"receiver {one.called_good} called good"] if one.called_good else []
        faults += ["false track"] if one.false_track else []
        outcome = "WRONG: " + ", ".join(faults) if faults else "right" if one.right else "not right"
        print(f"{name:42}{one.processor_s:13.1f} s  {outcome}; {one.status} {one.reason[:70]}", flush=True)
    for name, group in (("broken", [one for kind, one in rows if kind != WHOLE]), ("sound", _sound(rows))):
        called, tracks = sum(bool(one.called_good) for one in group), sum(one.false_track for one in group)
        right, longest_s = sum(one.right for one in group), max((one.processor_s for one in group), default=0.0)
        print(
            f"{name}: wrong receiver called good {called}, false track {tracks}, right {right} of {len(group)}; "
            f"longest {longest_s:.1f} s"
        )
    return sum(bool(one.called_good or one.false_track) for _, one in rows)


def _sound(rows: list[tuple[str, DropJudgement]]) -> list[DropJudgement]:
    return [one for kind, one in rows if kind == WHOLE]


PARTS = {"scenes": scenes, "garbage": garbage, "broken": broken}
KINDS_OF: dict[str, tuple[str, ...]] = {"scenes": (*KINDS,), "garbage": (*GARBAGE,), "broken": (*BROKEN, WHOLE)}


def main() -> int:
    """Print the tables, and return 1 where anything is silently wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--drops", type=int, default=30)
    parser.add_argument("--repeats", type=int, default=1, help="recordings of each kind of garbage")
    parser.add_argument("--part", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument(
        "--kind", choices=[kind for kinds in KINDS_OF.values() for kind in kinds], help="one kind only, and its part"
    )
    parser.add_argument("--correction", nargs="+", choices=CORRECTIONS, default=list(CORRECTIONS))
    parser.add_argument("--limit-s", type=float, default=120.0, help="processor time after which one is given up")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--verbose", action="store_true", help="a line for each scene")
    options = parser.parse_args()
    parts = options.part
    if options.kind:
        parts = [part for part, kinds in KINDS_OF.items() if options.kind in kinds]
    wrong = sum([PARTS[part](options) for part in parts])
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
