"""The short commands: report, devices, info."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from support.command_line import Called, Command

from radargui.cli.app import Devices
from radargui.cli.devices import list_devices
from radargui.model.errors import DeviceError
from radargui.sources.ni.discovery import NiDevice

PAD = NiDevice(
    "Dev1",
    "DAQPad-6015",
    "01A2B3C4",
    channels=tuple(f"ai{number}" for number in range(16)),
    ranges_v=((-0.05, 0.05), (-10.0, 10.0)),
    max_rate_single_hz=200e3,
    max_rate_multi_hz=200e3,
)


def test_a_report_names_its_four_files(command: Command, recorded: Path, tmp_path: Path) -> None:
    ended = command("report", recorded, "--output", tmp_path / "report")
    assert ended.status == 0
    paths = [Path(line.removeprefix("Report:").strip()) for line in ended.out.splitlines()]
    assert [path.suffix for path in paths] == [".pdf", ".html", ".csv", ".json"]
    assert all(path.parent == tmp_path / "report" and path.stat().st_size for path in paths)


def test_several_sessions_are_reported_each_and_as_a_series(command: Command, recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    copy = shutil.copytree(recorded, tmp_path / "other" / recorded.name)
    out = tmp_path / "report"
    ended = command("report", recorded, copy, "--output", out, "--law", "johnson")
    assert ended.status == 0
    paths = [Path(line[9:].strip()) for line in ended.out.splitlines()]
    folders = [out / recorded.name, out / f"{recorded.name}-2", out]
    assert [path.parent for path in paths] == [folder for folder in folders for _ in range(4)]
    assert all(path.stat().st_size for path in paths)
    document = json.loads((out / "report.json").read_text(encoding="utf-8"))
    assert document["speed_model"] == "johnson"
    assert len(document["sessions"]) == 2
    # the same drops twice are one series
    first, second = (one["series"]["e_first_bounce"]["n"] for one in document["sessions"])
    assert first >= 1
    assert second == 0
    assert "Johnson, fully plastic (chosen)" in (out / "report.html").read_text(encoding="utf-8")


def test_what_is_no_session_is_status_1_and_the_others_are_written_each_in_its_folder(
    command: Command, recorded: Path, tmp_path: Path
) -> None:
    empty = tmp_path / "empty-session"
    empty.mkdir()
    shutil.copy(recorded / "session.json", empty)
    ended = command("report", tmp_path / "absent", empty, "--output", tmp_path / "report")
    assert ended.status == 1
    assert "is not a session" in ended.error
    assert (tmp_path / "report" / "empty-session" / "report.pdf").is_file()
    assert "no report of the series" in ended.out
    assert not (tmp_path / "report" / "report.json").exists()


def test_a_run_that_cannot_be_read_is_status_1_and_named_beside_the_report_of_the_others(
    command: Command, recorded: Path, tmp_path: Path
) -> None:
    session = shutil.copytree(recorded, tmp_path / "session")
    (session / "run-0009.h5").write_bytes(b"no run at all")
    ended = command("report", session, "--output", tmp_path / "report")
    assert ended.status == 1
    assert ended.error.startswith(f"{session}: run-0009.h5 cannot be read")
    assert len(ended.error.splitlines()) == 1
    assert (tmp_path / "report" / "report.pdf").is_file()


def test_devices_are_listed_with_what_one_must_know_to_wire_them(called: Called) -> None:
    asked: list[str | None] = []

    def find(remote: str | None, _certificate: str | None) -> tuple[NiDevice, ...]:
        asked.append(remote)
        return (PAD,)

    ended = called(lambda: list_devices(Devices(remote="lab-pc:31763"), find))
    assert ended.status == 0
    assert asked == ["lab-pc:31763"]
    for fact in ("Dev1", "DAQPad-6015", "01A2B3C4", "16", "200 kS/s in all", "±0.05 10 V", "multiplexed"):
        assert fact in ended.out


def test_no_device_is_an_answer_and_no_driver_an_error(called: Called) -> None:
    ended = called(lambda: list_devices(Devices(), lambda _remote, _certificate: ()))
    assert ended.status == 0
    assert ended.out.startswith("No NI device is connected to this computer")
    assert "E Series" in ended.out

    def fail(_remote: str | None, _certificate: str | None) -> tuple[NiDevice, ...]:
        raise DeviceError("The NI-DAQmx driver is not installed on this computer.")

    ended = called(lambda: list_devices(Devices(), fail))
    assert ended.status == 1
    assert ended.error == "The NI-DAQmx driver is not installed on this computer."


@pytest.mark.parametrize("remote", ["lab-pc", "lab-pc:port", ":31763"])
def test_what_is_no_address_is_wrong_usage(command: Command, remote: str) -> None:
    ended = command("devices", "--remote", remote)
    assert ended.status == 2
    assert ended.error.startswith(f"--remote: '{remote}' is not the address of an NI gRPC device server.")


def test_info_tells_what_a_bug_report_needs(command: Command) -> None:
    ended = command("info")
    assert ended.status == 0
    facts = dict(line.split("  ", 1) for line in ended.out.splitlines())
    for name in ("RadarGUI", "Python", "numpy", "NI-DAQmx driver", "OpenGL library", "data folder", "log file"):
        assert facts[name].strip()
