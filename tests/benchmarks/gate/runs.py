"""Draws the scenes of a population, lets versions process them, and keeps each score where it was made once."""

from __future__ import annotations

import gzip
import hashlib
import json
import multiprocessing
import os
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from benchmarks.gate.scene_files import RUN, SETUP, read_truth, write_scene
from benchmarks.gate.score import Score
from benchmarks.gate.versions import KEPT, ROOT, Version

TESTS = ROOT / "tests"
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
BASELINE = Path(__file__).parents[1] / "baseline"
"""Scores that came with the checkout: of a version whose population takes hours."""
LONGEST_S = 1800.0
"""By the clock, for one scene: a version that has not answered by then never will."""


@dataclass(frozen=True)
class Population:
    """Scenes of one kind.

    Attributes
    ----------
    kind, seed, held
        As `benchmarks.world.kinds.draw` takes them.
    drops
        Of one session, with one set of antennas; 0: single scenes.
    asked
        Tables of the setup that replace those drawn, as {"processing": {"correction": "flights"}}.
    """

    kind: str
    seed: int
    held: Mapping[str, Any] = field(default_factory=dict)
    drops: int = 0
    asked: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def file_name(self) -> str:
        """Under which its scores are kept."""
        held, asked = (_digest(one) if one else "" for one in (self.held, self.asked))
        parts = (self.kind, self.seed, self.drops or "", held, asked)
        return "-".join(str(part) for part in parts if part != "") + ".jsonl"

    def write(self, number: int, folder: Path) -> list[Path]:
        """Draw one scene into a folder, or the drops of one session each into a folder of its own below it."""
        # only the processes that draw load the world
        from benchmarks.world.kinds import draw, draw_session

        if not self.drops:
            write_scene(draw(self.kind, self.seed, number, self.held), folder, self.asked)
            return [folder]
        scenes = draw_session(self.kind, self.seed, number, self.drops, self.held)
        places = [folder / str(drop) for drop in range(len(scenes))]
        for scene, place in zip(scenes, places, strict=True):
            place.mkdir()
            write_scene(scene, place, self.asked)
        return places


def _digest(values: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:8]


class Store:
    """Scores of one version on one population, a line of JSON each, written as they come.

    A score counts where the scene is still the same: the code that draws is, or else what it draws.
    """

    def __init__(self, version: Version, population: Population) -> None:
        self._path = KEPT / "scores" / version.key / population.file_name
        self._lock = threading.Lock()
        self._lines: dict[int, dict[str, Any]] = {}
        self._begin = ""
        baseline = BASELINE / version.key / f"{population.file_name}.gz"
        if baseline.is_file():
            self._take(gzip.decompress(baseline.read_bytes()).decode())
        if self._path.is_file():
            text = self._path.read_text(encoding="utf-8")
            # an interruption may have cut the last line: what follows must begin a new one
            self._begin = "" if text.endswith("\n") else "\n"
            self._take(text)

    def _take(self, text: str) -> None:
        for line in text.splitlines():
            with suppress(ValueError):
                one = json.loads(line)
                self._lines[one["number"]] = one

    def get(self, number: int, world: str = "", scene: str = "") -> list[Score] | None:
        """Return the scores of a number, made with this code of the world or of this very scene; None without."""
        one = self._lines.get(number)
        if one is None or not (one["world"] == world or one["scene"] == scene):
            return None
        return [Score.of_plain(each) for each in one["scores"]]

    def put(self, number: int, world: str, scene: str, scores: Sequence[Score]) -> None:
        """Keep the scores of a number."""
        one = {"number": number, "world": world, "scene": scene, "scores": [each.plain() for each in scores]}
        with self._lock:
            self._lines[number] = one
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(self._begin + json.dumps(one, separators=(",", ":")) + "\n")
            self._begin = ""


class Worker:
    """A process that has one version loaded and scores what it makes of scenes."""

    def __init__(self, version: Version) -> None:
        self._version = version
        self._log = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115 (closed by `close`)
        path = os.pathsep.join((str(version.folder), str(TESTS)))
        environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": path}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.gate.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            env=environment,
            cwd=version.folder,
            encoding="utf-8",
        )
        program = json.loads(self._answer() or "{}").get("program", "")
        if not Path(program).resolve().is_relative_to(version.folder.resolve()):
            self.close()
            raise RuntimeError(f"version {version.name} does not start: {program or self._said()}")

    def score(self, folder: Path, *, follows: bool = False) -> Score | None:
        """Return the score of the scene in a folder; None where the version ended without one, and `said` is why.

        It is of the same session as the one before where it `follows`.
        """
        assert self._process.stdin is not None
        self._process.stdin.write(f"{'next' if follows else 'first'} {folder}\n")
        self._process.stdin.flush()
        watch = threading.Timer(LONGEST_S, self._process.kill)
        watch.start()
        try:
            answer = self._answer()
        finally:
            watch.cancel()
        return Score.of_plain(json.loads(answer)) if answer else None

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._log.close()

    def said(self) -> str:
        """Return the last line that a process which ended printed."""
        self._process.wait()
        return self._said()

    def _said(self) -> str:
        self._log.seek(0)
        lines = self._log.read().strip().splitlines()
        return lines[-1] if lines else f"ended with status {self._process.returncode}"

    def _answer(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline()


class _Workers:
    """One worker of each version, for one thread; those that failed are started again."""

    def __init__(self) -> None:
        self._each: dict[Version, Worker] = {}

    def score(self, version: Version, folder: Path, *, follows: bool) -> Score:
        worker = self._each.get(version) or self._each.setdefault(version, Worker(version))
        found = worker.score(folder, follows=follows)
        if found is not None:
            return found
        truth, reason = read_truth(folder), worker.said()
        self._each.pop(version).close()
        return Score("fault", reason, (), None, truth.expected, truth.causes)

    def close(self) -> None:
        for one in self._each.values():
            one.close()
        self._each.clear()


def scores_of(
    population: Population, versions: Sequence[Version], numbers: Sequence[int], jobs: int = 1
) -> Iterator[tuple[int, dict[Version, list[Score]]]]:
    """Yield the scores of each number as they come, by version: of its one scene, or of the drops of its session.

    What is kept is not made again. At most `jobs` processes work at a time.
    """
    stores = {version: Store(version, population) for version in versions}
    world = world_key()
    with ExitStack() as stack:
        context = multiprocessing.get_context("spawn")
        drawing = stack.enter_context(ProcessPoolExecutor(jobs, context))
        free: queue.SimpleQueue[_Workers] = queue.SimpleQueue()
        for _ in range(jobs):
            workers = _Workers()
            stack.callback(workers.close)
            free.put(workers)
        threads = ThreadPoolExecutor(jobs)
        # ended first, and without what has not begun: an interrupted run goes on where it was
        stack.callback(threads.shutdown, cancel_futures=True)

        def one(number: int) -> tuple[int, dict[Version, list[Score]]]:
            kept = {version: stores[version].get(number, world=world) for version in versions}
            if all(kept.values()):
                return number, {version: scores or [] for version, scores in kept.items()}
            workers = free.get()
            try:
                with tempfile.TemporaryDirectory(prefix="radargui-scene-") as name:
                    places = drawing.submit(population.write, number, Path(name)).result()
                    scene = scene_key(places)
                    scores = {}
                    for version, store in stores.items():
                        made = store.get(number, scene=scene) or [
                            workers.score(version, place, follows=number > 0) for number, place in enumerate(places)
                        ]
                        # what a scene may be blamed on is the world's word of today
                        scores[version] = [_as_drawn(*pair) for pair in zip(made, places, strict=True)]
                        store.put(number, world, scene, scores[version])
                return number, scores
            finally:
                free.put(workers)

        yield from threads.map(one, numbers)


def kept_numbers(population: Population, versions: Sequence[Version], numbers: Iterable[int]) -> list[int]:
    """Return those of the numbers of which the scores of all versions are kept, made with this code of the world."""
    stores, world = [Store(version, population) for version in versions], world_key()
    return [number for number in numbers if all(store.get(number, world=world) for store in stores)]


def _as_drawn(score: Score, place: Path) -> Score:
    truth = read_truth(place)
    return replace(score, causes=truth.causes, expected=truth.expected)


def world_key() -> str:
    """Return a hash of the code that draws scenes."""
    digest = hashlib.sha256()
    for path in sorted((TESTS / "benchmarks" / "world").rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def scene_key(places: Sequence[Path]) -> str:
    """Return a hash of what was drawn: samples and setup, and the numbers that are true of them."""
    import h5py

    digest = hashlib.sha256()
    for place in places:
        with h5py.File(place / RUN) as file:
            digest.update(file["raw"][:].tobytes())
        digest.update((place / SETUP).read_bytes())
        truth = read_truth(place)
        digest.update(repr((truth.impacts, truth.gravity_m_s2, truth.start_s, truth.rate_hz)).encode())
    return digest.hexdigest()[:12]
