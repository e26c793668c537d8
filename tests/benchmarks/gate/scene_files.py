"""A scene on disk: what a version may read (`run.h5`, `setup.toml`), and the truth, which it never sees."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import tomlkit
from numpy.typing import NDArray

if TYPE_CHECKING:
    from benchmarks.world.kinds import PopulationRecord, PopulationScene

Array = NDArray[np.float64]

RUN, SETUP, TRUTH, TRACK = "run.h5", "setup.toml", "truth.json", "truth.npz"
INSTANTS = 500
"""Of the true motion that are kept, evenly over the record: shares and root mean squares need no more."""


class TrueImpact(NamedTuple):
    """One impact as it really was: speeds along the floor's normal; `on_floor` is false of walls beside the fall."""

    time_s: float
    before_m_s: float
    after_m_s: float
    e: float
    on_floor: bool


@dataclass(frozen=True)
class SceneTruth:
    """What is true of one record.

    Attributes
    ----------
    name, kind, causes, expected
        Of the scene: what was drawn into it, and whether it can be processed ("ok", "refused", "either").
    index
        Samples (lost ones counted) of which the motion is kept, shape (m,).
    position_m, path_m
        Centre of the sphere (3, m), None where a record of one or two receivers tells none; paths (n_receivers, m).
    rate_hz, end_s
        Samples per second as the file says; end of the record.
    start_s
        When the motion begins.
    impacts, gravity_m_s2
        In time order; acceleration of the free fall, None where nothing falls.
    """

    name: str
    kind: str
    causes: frozenset[str]
    expected: str
    index: NDArray[np.int64]
    position_m: Array | None
    path_m: Array
    rate_hz: float
    end_s: float
    start_s: float
    impacts: tuple[TrueImpact, ...]
    gravity_m_s2: float | None


def write_scene(scene: PopulationScene, folder: Path, asked: Mapping[str, Mapping[str, Any]] | None = None) -> None:
    """Make the record of a scene and write it with its setup and its truth into a folder that is there.

    `asked`: tables whose values replace those of the setup.
    """
    # only who draws needs the writer: a version under test brings its own package of that name
    from radargui.files.run_writer import RunWriter
    from radargui.model.recording import LARGEST_INDEX

    record = scene.record()
    recording = record.recording
    writer = RunWriter(folder / RUN, recording.digitisation, started_at="", trigger_index=recording.trigger_index)
    for block in recording.blocks(LARGEST_INDEX):
        writer.write(block)
    writer.close()
    setup = dict(scene.setup)
    for table, values in (asked or {}).items():
        setup[table] = {**setup.get(table, {}), **values}
    (folder / SETUP).write_text(tomlkit.dumps(setup), encoding="utf-8")
    truth = truth_of(scene, record)
    np.savez_compressed(
        folder / TRACK,
        index=truth.index,
        path_m=truth.path_m,
        **({} if truth.position_m is None else {"position_m": truth.position_m}),
    )
    facts = {
        "name": truth.name,
        "kind": truth.kind,
        "causes": sorted(truth.causes),
        "expected": truth.expected,
        "rate_hz": truth.rate_hz,
        "end_s": truth.end_s,
        "start_s": truth.start_s,
        "impacts": truth.impacts,
        "gravity_m_s2": truth.gravity_m_s2,
    }
    (folder / TRUTH).write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")


def truth_of(scene: PopulationScene, record: PopulationRecord) -> SceneTruth:
    """Return the truth of a record, its motion at `INSTANTS` samples."""
    recording = record.recording
    index = recording.index()
    kept = np.unique((np.arange(0.5, INSTANTS) * recording.n_samples / INSTANTS).astype(np.int64))
    rate_hz = recording.digitisation.sample_rate_hz
    return SceneTruth(
        scene.name,
        scene.kind,
        frozenset(scene.causes),
        record.expected,
        index[kept],
        None if record.position_m is None else record.position_m[:, kept],
        record.path_m[:, kept],
        rate_hz,
        float(index[-1] + 1) / rate_hz,
        float(record.start_s),
        tuple(TrueImpact(*map(float, one[:4]), bool(one[4])) for one in record.impacts),
        None if record.gravity_m_s2 is None else float(record.gravity_m_s2),
    )


def read_truth(folder: Path) -> SceneTruth:
    """Return the truth that `write_scene` left in a folder."""
    facts = json.loads((folder / TRUTH).read_text(encoding="utf-8"))
    with np.load(folder / TRACK) as arrays:
        track = {name: arrays[name] for name in arrays.files}
    impacts = tuple(TrueImpact(*one) for one in facts.pop("impacts"))
    causes = frozenset(facts.pop("causes"))
    return SceneTruth(**facts, causes=causes, impacts=impacts, **{"position_m": None, **track})


def read_plain_setup(folder: Path) -> Mapping[str, Any]:
    """Return the tables of the setup that stands beside a run."""
    return tomllib.loads((folder / SETUP).read_text(encoding="utf-8"))
