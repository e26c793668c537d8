"""Runs the estimate on scenes of the laboratory and prints how right it is."""

from __future__ import annotations

import time
from collections.abc import Iterable

from benchmarks.scoring.laboratory import Score, score
from benchmarks.scoring.table import line
from benchmarks.world.scene import Scene, make_record

from radargui.model.errors import ProcessingError
from radargui.processing.process import process


def run(scenes: Iterable[Scene]) -> list[Score]:
    """Score every scene; print as they come."""
    scores = []
    for scene in scenes:
        record = make_record(scene)
        begin = time.process_time()
        try:
            result = process(record.recording, record.scene.setup)
        except ProcessingError as error:
            print(f"{scene.name:16s} {error}", flush=True)
            continue
        scores.append(score(record, result, time.process_time() - begin))
        print(line(scene, scores[-1]), flush=True)
        for warning in scores[-1].warnings:
            print(f"{'':16s} {warning}", flush=True)
    return scores
