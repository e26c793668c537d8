"""`radargui calibrate`: what it writes, what it refuses, and the check by one drop."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from support.command_line import Called, Command

from radargui.calibration.calibrate import Calibrated, calibrated_setup
from radargui.calibration.fit import Fit
from radargui.calibration.likelihood import World
from radargui.calibration.rough_fit import KnownRecording
from radargui.calibration.unknowns import antenna_unknowns
from radargui.cli.app import Calibrate
from radargui.cli.calibrate import calibrate_antennas
from radargui.experiment.calibrating import calibrate_files
from radargui.model.calibration import Calibration, Origin, Residual
from radargui.model.errors import ProcessingError
from radargui.model.setup import Setup, read_setup

RESOURCES = Path(__file__).parents[2] / "resources"
SETUP, PATH = RESOURCES / "setups" / "laboratory.toml", RESOURCES / "paths" / "turntable.toml"


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "circle.csv"
    time = np.arange(200) / 1000.0
    table = np.column_stack([time, *(np.cos(40.0 * time + k) for k in range(6))])
    np.savetxt(path, table, delimiter=",", header="time_s,I1,Q1,I2,Q2,I3,Q3", comments="")
    return path


def found_by(setup: Setup, verdict: str) -> Calibrated:
    """Return a calibration that moves the first receiver's tilt by a degree."""
    world = World(setup, tuple(antenna_unknowns(setup)))
    n = len(world.unknowns)
    values = np.array([one.value for one in world.unknowns])
    names = tuple(one.name for one in world.unknowns)
    u = np.array([one.u for one in world.unknowns])
    moved = values + 1.0 * np.array([name == "receiver.1.tilt_deg" for name in names])
    calibration = Calibration(
        names, values, moved, u, np.diag((0.1 * u) ** 2), (),
        (Residual("circle", 1, 1e-5, 1e-3, 2e-5),), verdict, "why",
        Origin("2026-11-21", "", "0", {"circle": "abc"}, ("turntable",)),
    )  # fmt: skip
    found = Fit(world, np.zeros(n), (), (), np.zeros(n, dtype=bool))
    return Calibrated(calibration, calibrated_setup(setup, found, calibration), found)


def test_the_whole_setup_is_written_with_the_values_and_their_u(
    called: Called, recording: Path, tmp_path: Path
) -> None:
    asked: list[KnownRecording] = []

    def calibrated(recordings: list[KnownRecording], setup: Setup, *_: object, **__: object) -> Calibrated:
        asked.extend(recordings)
        return found_by(setup, "good")

    output = tmp_path / "new.toml"
    options = Calibrate(files=[recording], known=[str(PATH)], setup=SETUP, output=output)
    done = called(lambda: calibrate_antennas(options, partial(calibrate_files, fit=calibrated)))
    assert done.status == 0, done.err
    before, after = read_setup(SETUP), read_setup(output)
    assert after.receiver[0].tilt_deg == pytest.approx(before.receiver[0].tilt_deg + 1.0)
    assert after.receiver[0].u_tilt_deg == pytest.approx(0.1 * (before.receiver[0].u_tilt_deg or 0.0), rel=5e-3)
    assert after.simulation == before.simulation
    assert "# steel; for the buoyancy in air" in output.read_text()
    assert asked[0].trajectory is not None
    assert asked[0].trajectory.words == "turntable, radius 60 mm"
    assert len(asked[0].checksum) == 64
    kept = json.loads(output.with_suffix(".calibration.json").read_text())
    assert kept["verdict"] == "good"
    again = called(lambda: calibrate_antennas(options))
    assert again.status == 2
    assert "--force" in again.error


def test_what_is_refused_writes_nothing(called: Called, recording: Path, tmp_path: Path) -> None:
    output = tmp_path / "new.toml"
    options = Calibrate(files=[recording], known=[str(PATH)], setup=SETUP, output=output)
    done = called(lambda: calibrate_antennas(options, lambda order, _: found_by(order.setup, "refused").calibration))
    assert done.status == 1
    assert "nothing was written: why" in done.error
    assert not output.exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "needs FILE"),
        (("FILE", "--known", PATH, "--known", "fall", "--output", "OUT"), "1 FILEs and 2 times --known"),
        (("FILE", "--known", PATH, "--output", "OUT", "--free", "tilt,colour"), "'colour'"),
        (("FILE", "--known", "none.toml", "--output", "OUT", "--setup", SETUP), "none.toml"),
        (("FILE", "--known", PATH, "--output", "OUT"), "no setup"),
    ],
)
def test_wrong_usage_is_said_in_one_line(
    command: Command, recording: Path, tmp_path: Path, options: tuple[object, ...], said: str
) -> None:
    names = {"FILE": recording, "OUT": tmp_path / "out.toml"}
    done = command("calibrate", *(names.get(str(one), one) for one in options))
    assert done.status == 2
    assert said in done.error


def test_times_that_do_not_overlap_are_said(tmp_path: Path) -> None:
    from radargui.calibration.known_path import read_known
    from radargui.calibration.preparing import refuse_apart

    table = tmp_path / "late.csv"
    table.write_text("time_s,x_m,y_m,z_m\n" + "".join(f"{100 + k},0,0,{k / 100}\n" for k in range(5)))
    with pytest.raises(ProcessingError, match="do not overlap"):
        refuse_apart("circle", 0.0, 5.0, read_known(table, "shared"))
