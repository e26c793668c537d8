"""Small files of every format for tests, made here from known samples."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from nptdms import ChannelObject, TdmsWriter
from support.small_setups import quick_setup

from radargui.files.formats import RUN, format_of, list_channels
from radargui.files.raw_file import RawLayout
from radargui.files.reading import read_recording
from radargui.files.run_writer import RunWriter
from radargui.files.signals import assemble
from radargui.model.channel_quality import ChannelQuality
from radargui.model.errors import FileError
from radargui.model.finding import as_stored, warn
from radargui.model.recording import Block, Digitisation, Gap, Recording, Truth, iq_names
from radargui.model.result import Bounce, Bounces, CorrectedIQ, FreeFall, Kinematics, PathLengths, RunResult, Track
from radargui.model.setup import Setup, dump_setup
from radargui.model.uncertainty_budget import BudgetLine, UncertaintyBudget

RATE_HZ = 1000.0


def read_all_channels(path: Path, raw: RawLayout | None = None) -> Recording:
    """All channels of a file of another program under the names they have, whatever these are."""
    kind, names = format_of(path, raw), [info.name for info in list_channels(path, raw)]
    if kind is RUN:
        return read_recording(path)
    if not names:
        raise FileError(f"{path} holds no samples.")
    return assemble([kind.read(path, names)], names, name=path.stem, where=str(path), rate_hz=None)


def default_setup() -> Setup:
    return quick_setup()


def int16_digitisation(rate_hz: float = RATE_HZ, n_receivers: int = 3) -> Digitisation:
    scaling = tuple((0.001 * k, 1.5e-4) for k in range(2 * n_receivers))
    return Digitisation(iq_names(n_receivers), rate_hz, scaling, channel_skew_s=5e-6, device="simulated")


def codes(n_channels: int, count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(-32768, 32767, (n_channels, count), dtype=np.int16, endpoint=True)


def volts(n_channels: int, count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(n_channels, count))


def write_run(path: Path, count: int = 1800, *, gap: bool = True) -> np.ndarray:
    """Write a whole run file and return its codes."""
    samples = codes(6, count)
    half = count // 2
    lost = Gap(half, 10, "overflow") if gap else None
    with RunWriter(
        path, int16_digitisation(), started_at="2026-11-20T15:04:05+01:00", setup_toml=dump_setup(default_setup())
    ) as writer:
        writer.write(Block(samples[:, :half], 0))
        writer.write(Block(samples[:, half:], half + (10 if gap else 0), lost))
        writer.add_marker(5, "Größe 10 mm")
        writer.write_truth(Truth(volts(3, count), volts(3, count), np.array([0.5, 0.9])))
    return samples


def write_csv(path: Path, samples: np.ndarray, *, rate_hz: float | None = RATE_HZ, names: str = "") -> Path:
    header = names or ",".join(iq_names(samples.shape[0] // 2))
    rows = [",".join(f"{value!r}" for value in column) for column in samples.T.tolist()]
    if rate_hz is not None:
        header = f"time_s,{header}"
        rows = [f"{k / rate_hz!r},{row}" for k, row in enumerate(rows)]
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def write_mat5(path: Path, samples: np.ndarray, *, compressed: bool = True) -> Path:
    scipy.io.savemat(
        path,
        {
            "src1": {"Data": samples[0].astype(np.float32), "SampleFrequency": RATE_HZ, "Unit": "V", "Name": "one"},
            "I1": samples[0],
            "Q1": samples[1],
            "table": samples,
            "Fs": 2 * RATE_HZ,
            "mixed": np.array([1.0, "two"], dtype=object),
        },
        do_compression=compressed,
    )
    return path


def write_mat73(path: Path, samples: np.ndarray) -> Path:
    """Write what MATLAB's `save -v7.3` writes: HDF5 behind 512 bytes of its own header."""
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("src1")
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for place, name, values in (
            (group, "Data", samples[0][:, None].T),
            (group, "SampleFrequency", np.array([[RATE_HZ]])),
            (file, "I1", samples[0][None, :]),
            (file, "Q1", samples[1][:, None]),
            (file, "table", samples.T),
            (file, "Fs", np.array([[2 * RATE_HZ]])),
        ):
            chunks = {"chunks": values.shape, "compression": "gzip"} if values.size > 100 else {}
            place.create_dataset(name, data=values, **chunks).attrs["MATLAB_class"] = np.bytes_("double")
        unit = group.create_dataset("Unit", data=np.array([[109], [86]], dtype=np.uint16))
        unit.attrs["MATLAB_class"] = np.bytes_("char")
        empty = file.create_dataset("empty", data=np.array([0, 0], dtype=np.uint64))
        empty.attrs["MATLAB_empty"] = np.uint8(1)
        file.create_group("#refs#")
    content = bytearray(path.read_bytes())
    content[:128] = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    path.write_bytes(content)
    return path


def write_tdms(path: Path, samples: np.ndarray, names: list[str], properties: dict[str, object]) -> Path:
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [ChannelObject("group", name, row, properties) for name, row in zip(names, samples, strict=True)]
        )
    return path


def write_sigmf(path: Path, components: np.ndarray, datatype: str, n_channels: int, **facts: object) -> Path:
    """Write components (n_samples, n_components) as a SigMF pair and return the path of the metadata."""
    meta = path.with_suffix(".sigmf-meta")
    path.with_suffix(".sigmf-data").write_bytes(np.ascontiguousarray(components).tobytes())
    captures = facts.pop("captures", [{"core:sample_start": 0}])
    annotations = facts.pop("annotations", [])
    content = {
        "global": {
            "core:datatype": datatype,
            "core:num_channels": n_channels,
            "core:sample_rate": RATE_HZ,
            "core:version": "1.2.0",
            **facts,
        },
        "captures": captures,
        "annotations": annotations,
    }
    meta.write_text(json.dumps(content), encoding="utf-8")
    return meta


def result_of(recording: Recording) -> RunResult:
    """Return a result with everything in it, of made-up figures."""
    n = recording.n_samples
    time_s = recording.time_s()
    valid = np.ones((3, n), dtype=bool)
    quality = tuple(
        ChannelQuality(str(k), snr_db=35.0, finding=finding)
        for k, finding in enumerate((None, warn("signal_low"), None), 1)
    )
    bounces = Bounces(
        (
            Bounce(0.2, 2.0, 1.6, 0.8, 0.01, "fit", valid=True, x_m=0.01, angle_deg=4.0, e_t=0.7, mu=0.05),
            Bounce(0.4, 1.6, 0.8, 0.5, 0.1, "fit", valid=False),
        ),
        FreeFall(9.81, 0.02, 0.0, 0.2, 0.12, 0.26, (0.12, 0.0, -4.905), 1e-5),
    )
    return RunResult(
        recording,
        default_setup(),
        "ok",
        corrected=CorrectedIQ(
            time_s, volts(3, n), volts(3, n), valid, volts(3, n), "published", quality, decisions=("A floor is kept.",)
        ),
        paths=PathLengths(time_s, volts(3, n), volts(3, n), volts(3, n), valid),
        track=Track(time_s, volts(3, n), volts(3, n), valid[0], "exact"),
        bounces=bounces,
        motion=Kinematics(time_s, *(volts(3, n) for _ in range(6)), np.arange(n) // 100 - 1),
        uncertainty_budget=UncertaintyBudget(
            e=BudgetLine(0.001, 0.002, None, 0.003), assumed={"daq.u_clock_ppm": 50.0}
        ),
        findings=(as_stored("A warning."),),
    )
