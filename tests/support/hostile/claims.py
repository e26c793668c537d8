"""Small files whose headers claim terabytes, nest without end, or point elsewhere."""

from __future__ import annotations

import gzip
import io
import struct
import tarfile
import zlib
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
from support.file_samples import codes, default_setup, volts, write_mat73, write_run, write_sigmf, write_tdms

from radargui.files.formats import EXPORT_FORMATS, export_run
from radargui.model.setup import dump_setup

TERA = 10**12


def _run_with(folder: Path, change: Callable[[h5py.File], None]) -> Path:
    path = folder / "run-0001.h5"
    write_run(path, 300)
    with h5py.File(path, "r+") as file:
        for key in ("crc32", "attributes_crc32"):
            del file.attrs[key]
        del file["raw"].attrs["attributes_crc32"]
        change(file)
    return path


def run_of_a_terabyte(folder: Path) -> Path:
    return _run_with(folder, lambda file: file["raw"].resize(TERA, axis=1))


def run_that_was_never_filled(folder: Path) -> Path:
    def change(file: h5py.File) -> None:
        attributes = dict(file["raw"].attrs)
        del file["raw"]
        file.create_dataset("raw", (6, TERA), np.int16)
        file["raw"].attrs.update(attributes)

    return _run_with(folder, change)


def run_with_a_terabyte_of_gaps(folder: Path) -> Path:
    return _run_with(folder, lambda file: file["gaps"].resize(TERA, axis=0))


def run_with_a_gap_beyond_all_time(folder: Path) -> Path:
    def change(file: h5py.File) -> None:
        file["gaps"][0] = (2**62, 2**62, b"x")

    return _run_with(folder, change)


def run_whose_samples_are_another_file(folder: Path) -> Path:
    np.zeros(6 * 300, dtype=np.int16).tofile(folder / "secret.bin")

    def change(file: h5py.File) -> None:
        attributes = dict(file["raw"].attrs)
        del file["raw"]
        outside = [(str(folder / "secret.bin"), 0, 6 * 300 * 2)]
        file.create_dataset("raw", (6, 300), np.int16, external=outside)
        file["raw"].attrs.update(attributes)

    return _run_with(folder, change)


def run_that_links_to_another_run(folder: Path) -> Path:
    write_run(folder / "other.h5", 100)

    def change(file: h5py.File) -> None:
        del file["raw"]
        file["raw"] = h5py.ExternalLink("other.h5", "/raw")

    return _run_with(folder, change)


def mat73_of_a_terabyte(folder: Path) -> Path:
    path = write_mat73(folder / "a.mat", volts(2, 100))
    with h5py.File(path, "r+") as file:
        for name in ("I1", "Q1"):
            del file[name]
            file.create_dataset(name, (TERA, 1), np.float64, chunks=(1000, 1))
    return path


def exported_mat73_with_a_terabyte_of_facts(folder: Path) -> Path:
    path = write_mat73(folder / "a.mat", volts(2, 100))
    with h5py.File(path, "r+") as file:
        facts = file.create_dataset("radargui", (TERA, 1), np.uint16, chunks=(1000, 1))
        facts.attrs["MATLAB_class"] = np.bytes_("char")
    return path


def _mat5(content: bytes) -> bytes:
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + content


def _mat5_array(rows: int, numbers: int) -> bytes:
    header = (
        struct.pack("<IIII", 6, 8, 6, 0)
        + struct.pack("<IIii", 5, 8, rows, 1)
        + struct.pack("<II", 1, 2)
        + b"I1".ljust(8, b"\0")
    )
    body = header + struct.pack("<II", 9, numbers)
    return struct.pack("<II", 14, (len(body) + numbers) & 0xFFFFFFFF) + body


def mat5_of_two_thousand_million_rows(folder: Path) -> Path:
    (folder / "a.mat").write_bytes(_mat5(_mat5_array(2**31 - 1, 64) + bytes(64)))
    return folder / "a.mat"


def mat5_that_swells(folder: Path) -> Path:
    swollen = zlib.compress(_mat5_array(2**29, 2**32 - 256) + bytes(3_000_000), 9)
    (folder / "a.mat").write_bytes(_mat5(struct.pack("<II", 15, len(swollen)) + swollen))
    return folder / "a.mat"


def tdms_of_a_terabyte(folder: Path) -> Path:
    path = write_tdms(folder / "a.tdms", codes(2, 60), ["I1", "Q1"], {"wf_increment": 1e-3})
    content = path.read_bytes()
    path.write_bytes(content.replace(struct.pack("<Q", 60), struct.pack("<Q", TERA)))
    return path


def tdms_with_a_name_of_four_gigabytes(folder: Path) -> Path:
    path = write_tdms(folder / "a.tdms", codes(2, 60), ["I1", "Q1"], {"wf_increment": 1e-3})
    content = path.read_bytes()
    path.write_bytes(
        content.replace(struct.pack("<L", 12) + b"wf_increment", struct.pack("<L", 2**32 - 1) + b"wf_increment")
    )
    return path


def sigmf_of_many_channels(folder: Path) -> Path:
    return write_sigmf(folder / "a", codes(2, 50).T, "ci16_le", TERA)


def sigmf_with_an_annotation_beyond_its_end(folder: Path) -> Path:
    far = [{"core:sample_start": TERA, "core:sample_count": TERA}]
    return write_sigmf(folder / "a", codes(2, 50).T, "ci16_le", 1, annotations=far)


def sigmf_whose_data_are_elsewhere(folder: Path) -> Path:
    (folder.parent / "secret.bin").write_bytes(bytes(400))
    meta = write_sigmf(folder / "a", codes(2, 50).T, "ci16_le", 1, **{"core:dataset": "../secret.bin"})
    meta.with_suffix(".sigmf-data").unlink()
    return meta


def sigmf_archive_of_a_terabyte(folder: Path) -> Path:
    meta = write_sigmf(folder / "a", codes(2, 50).T, "ci16_le", 1)
    with tarfile.open(folder / "b.sigmf", "w") as archive:
        archive.add(meta, "a/a.sigmf-meta")
        claim = tarfile.TarInfo("a/a.sigmf-data")
        claim.size = TERA
        archive.addfile(claim)
    return folder / "b.sigmf"


def sigmf_archive_whose_metadata_are_a_terabyte(folder: Path) -> Path:
    with tarfile.open(folder / "b.sigmf", "w") as archive:
        claim = tarfile.TarInfo("a/a.sigmf-meta")
        claim.size = TERA
        archive.addfile(claim)
    return folder / "b.sigmf"


def sigmf_archive_that_swells(folder: Path) -> Path:
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode="w") as archive:
        info = tarfile.TarInfo("a/a.sigmf-meta")
        info.size = 200_000_000
        archive.addfile(info, io.BytesIO(bytes(info.size)))
    (folder / "b.sigmf").write_bytes(gzip.compress(stream.getvalue(), 6))
    return folder / "b.sigmf"


def csv_with_two_million_columns(folder: Path) -> Path:
    (folder / "a.csv").write_text(",".join(f"c{k}" for k in range(2_000_000)) + "\n", encoding="utf-8")
    return folder / "a.csv"


def csv_that_claims_an_export_of_a_terabyte(folder: Path) -> Path:
    write_run(folder / "run-0001.h5", 20)
    (path,) = export_run(folder / "run-0001.h5", EXPORT_FORMATS["csv"], folder)
    text = path.read_text(encoding="utf-8").replace("count = 10", f"count = {2**60}")
    path.write_text(text.replace("time_s,I1", "time_s,I1,I1"), encoding="utf-8")
    return path


def setup_nested_without_end(folder: Path) -> Path:
    (folder / "setup.toml").write_text("a = " + "[" * 400_000, encoding="utf-8")
    return folder / "setup.toml"


def setup_with_a_key_of_many_parts(folder: Path) -> Path:
    (folder / "setup.toml").write_text(".".join("a" * 20_000) + " = 1\n", encoding="utf-8")
    return folder / "setup.toml"


def setup_with_a_number_of_many_digits(folder: Path) -> Path:
    text = dump_setup(default_setup()).replace("frequency_hz = 10000000000.0", "frequency_hz = " + "9" * 900_000)
    (folder / "setup.toml").write_text(text, encoding="utf-8")
    return folder / "setup.toml"


def setup_far_too_long(folder: Path) -> Path:
    with (folder / "setup.toml").open("wb") as file:
        file.truncate(TERA // 100)
    return folder / "setup.toml"


def session_record_far_too_long(folder: Path) -> Path:
    with (folder / "session.json").open("wb") as file:
        file.truncate(TERA // 100)
    return folder / "session.json"


def session_record_nested_without_end(folder: Path) -> Path:
    (folder / "session.json").write_text("[" * 5_000_000, encoding="utf-8")
    return folder / "session.json"


CLAIMS: dict[str, Callable[[Path], Path]] = {
    name: make
    for name, make in list(globals().items())
    if callable(make) and getattr(make, "__module__", "") == __name__ and not name.startswith("_")
}
