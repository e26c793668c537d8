"""The tables of a run keep the contract that other programs rely on."""

from __future__ import annotations

import csv
import errno
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.changed import changed
from support.results import drop_result, quiet_result, rejected_result

from radargui import __version__
from radargui.model.errors import FileError
from radargui.model.finding import as_stored
from radargui.model.recording import Excerpt
from radargui.model.result import Kinematics, whole_milliseconds
from radargui.report.findings_section import setup_blocks
from radargui.report.tables import write_tables

TRACK = (
    "time_s,L1_m,L2_m,L3_m,x_m,y_m,z_m,ux_m,uy_m,uz_m,valid,piece,u_L1_m,u_L2_m,u_L3_m,"
    "ux_combined_m,uy_combined_m,uz_combined_m"
)
VALID, PIECE = 10, 11
BOUNCES = (
    "time_s,speed_before_m_s,speed_after_m_s,e,u_e,method,valid,u_e_combined,x_m,y_m,z_m,u_position_m,"
    "u_speed_before_m_s,u_speed_after_m_s,angle_deg,u_angle_deg,vt_before_m_s,vt_after_m_s,e_t,u_e_t"
)
MOTION = (
    "time_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,ax_m_s2,ay_m_s2,az_m_s2,u_x_m,u_y_m,u_z_m,u_vx_m_s,u_vy_m_s,u_vz_m_s,"
    "u_ax_m_s2,u_ay_m_s2,u_az_m_s2,flight"
)
TABLES = ["bounces.csv", "motion.csv", "result.json", "track.csv"]
KEYS = [
    "status",
    "reason",
    "version",
    "setup",
    "correction_used",
    "geometry_used",
    "channel_skew_s",
    "channel_skew_from",
    "channels",
    "air",
    "free_fall",
    "e_by_times",
    "uncertainty_budget",
    "setup_posterior",
    "warnings",
    "findings",
]


def read_csv(path: Path) -> list[list[str]]:
    return list(csv.reader(path.read_text(encoding="utf-8").splitlines()))


def strict_json(path: Path) -> dict[str, object]:
    def refuse(text: str) -> None:
        raise AssertionError(f"{text} is not JSON")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def test_the_track_has_one_row_per_sample_with_the_columns_of_the_contract(tmp_path: Path) -> None:
    result = drop_result(rate_hz=2000.0)
    combined = 3.0 * result.track.u_position_m
    result = replace(result, track=replace(result.track, u_combined_m=combined))
    write_tables(result, tmp_path / "new" / "run-0001")
    path = tmp_path / "new" / "run-0001" / "track.csv"
    data = path.read_bytes()
    assert data.startswith((TRACK + "\n").encode())
    assert b"\r" not in data
    assert data.endswith(b"\n")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    assert table.shape == (result.recording.n_samples, 18)
    assert result.paths is not None
    assert result.track is not None
    np.testing.assert_allclose(table[:, 0], np.arange(len(table)) / 2000.0, atol=1e-12)
    np.testing.assert_allclose(table[:, 1:4], result.paths.change_m.T, atol=0.51e-9)
    np.testing.assert_allclose(table[:, 4:7], result.track.position_m.T, atol=0.51e-9)
    np.testing.assert_allclose(table[:, 7:10], result.track.u_position_m.T, atol=1.01e-9)
    assert set(table[:, VALID]) == {1.0}
    assert set(table[:, PIECE]) == {0.0}
    np.testing.assert_allclose(table[:, 12:15], result.paths.u_m.T, atol=1.01e-9)
    np.testing.assert_allclose(table[:, 15:], result.track.u_combined_m.T, atol=1.01e-9)
    assert sorted(item.name for item in path.parent.iterdir()) == TABLES


def test_unknown_values_are_nan_and_not_valid(tmp_path: Path) -> None:
    result = drop_result(rate_hz=1000.0)
    assert result.track is not None
    assert result.paths is not None
    position, change = result.track.position_m.copy(), result.paths.change_m.copy()
    position[:, 700:], change[1, 700:] = np.nan, np.inf
    valid = np.arange(position.shape[1]) < 700
    result = replace(
        result,
        track=replace(result.track, position_m=position, valid=valid),
        paths=replace(result.paths, change_m=change),
    )
    write_tables(result, tmp_path)
    row = read_csv(tmp_path / "track.csv")[701]
    assert row[2] == "nan"
    assert row[4:7] == ["nan", "nan", "nan"]
    assert row[VALID] == "0"
    assert row[12:15] == ["0.000024000", "nan", "0.000024000"]
    assert read_csv(tmp_path / "track.csv")[700][VALID] == "1"


def test_times_are_index_over_rate_to_the_picosecond_or_the_files_own(tmp_path: Path) -> None:
    result = drop_result(rate_hz=33333.0, seconds=0.6)
    write_tables(result, tmp_path)
    times = np.array([float(row[0]) for row in read_csv(tmp_path / "track.csv")[1:]])
    assert np.abs(times - np.arange(times.size) / 33333.0).max() <= 0.51e-12
    own = np.cumsum(np.full(result.recording.n_samples, np.pi * 1e-5))
    write_tables(replace(result, recording=replace(result.recording, file_time_s=own)), tmp_path)
    times = np.array([float(row[0]) for row in read_csv(tmp_path / "track.csv")[1:]])
    assert np.abs(times - own).max() <= 0.51e-12


def test_one_row_per_impact_with_positive_speeds(tmp_path: Path) -> None:
    result = drop_result(rate_hz=2000.0)
    write_tables(result, tmp_path)
    rows = read_csv(tmp_path / "bounces.csv")
    assert ",".join(rows[0]) == BOUNCES
    assert len(rows) == 1 + len(result.bounces.impacts) > 3
    assert float(rows[1][3]) == pytest.approx(0.8)
    assert float(rows[1][2]) / float(rows[1][1]) == pytest.approx(float(rows[1][3]), rel=1e-11)
    assert rows[1][5:] == ["hand", "1", *["nan"] * 13]
    impact = replace(result.bounces.impacts[0], x_m=0.01, angle_deg=3.0, e_t=0.7, u_e_t=0.02)
    write_tables(replace(result, bounces=replace(result.bounces, impacts=(impact,))), tmp_path)
    (row,) = read_csv(tmp_path / "bounces.csv")[1:]
    said = dict(zip(BOUNCES.split(","), row, strict=True))
    assert [float(said[name]) for name in ("x_m", "angle_deg", "e_t", "u_e_t")] == [0.01, 3.0, 0.7, 0.02]


def test_the_motion_has_a_thousand_rows_a_second_with_velocity_and_acceleration(tmp_path: Path) -> None:
    time = whole_milliseconds(0.2996, 0.7)
    rows = np.arange(3 * time.size).reshape(3, -1) / 1e3
    motion = Kinematics(
        time, rows, rows + 1.0, rows - 9.81, 1e-5 + 0.0 * rows, 2e-4 + 0.0 * rows, 3e-2 + 0.0 * rows, 0 * time
    )
    write_tables(replace(drop_result(rate_hz=1000.0), motion=replace(motion, flight=np.full(time.size, -1))), tmp_path)
    lines = (tmp_path / "motion.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == MOTION
    assert lines[1].startswith("0.300,0.000000000,")
    assert lines[1].endswith(",-1")
    table = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1)
    assert table.shape == (401, 20)
    np.testing.assert_allclose(table[:, 0], np.arange(300, 701) / 1e3)
    np.testing.assert_allclose(table[:, 4:7], motion.velocity_m_s.T, atol=1e-9)
    np.testing.assert_allclose(table[:, 7:10], motion.acceleration_m_s2.T, atol=1e-9)
    np.testing.assert_allclose(table[:, 16:19], 3e-2, atol=2e-9)


def test_where_velocities_are_not_known_the_motion_has_its_header_alone(tmp_path: Path) -> None:
    write_tables(drop_result(rate_hz=1000.0), tmp_path)
    assert (tmp_path / "motion.csv").read_text(encoding="utf-8") == MOTION + "\n"
    write_tables(drop_result(rate_hz=1000.0, n_receivers=2), tmp_path / "two")
    assert not (tmp_path / "two" / "motion.csv").exists()


def test_no_motion_gives_headers_only_and_says_so(tmp_path: Path) -> None:
    write_tables(quiet_result(), tmp_path)
    assert (tmp_path / "track.csv").read_text(encoding="utf-8") == TRACK + "\n"
    assert (tmp_path / "bounces.csv").read_text(encoding="utf-8") == BOUNCES + "\n"
    document = strict_json(tmp_path / "result.json")
    assert list(document) == KEYS
    assert document["status"] == "no_motion"
    assert document["reason"] == "nothing moves in this recording"
    said = {"code": "stored", "severity": "refuse", "receiver": None, "text": document["reason"]}
    assert document["findings"] == [{**said, "facts": {"text": document["reason"]}}]
    for key in ("correction_used", "geometry_used", "channels", "air", "free_fall", "uncertainty_budget"):
        assert document[key] is None


def test_a_rejected_run_has_its_samples_but_nothing_known_of_them(tmp_path: Path) -> None:
    write_tables(rejected_result(samples=500), tmp_path)
    rows = read_csv(tmp_path / "track.csv")
    assert len(rows) == 501
    assert rows[250][1:] == ["nan"] * 9 + ["0", "0"] + ["nan"] * 6
    assert strict_json(tmp_path / "result.json")["status"] == "rejected"


@pytest.mark.parametrize("n_receivers", [1, 3])
def test_no_row_of_a_rejected_run_is_valid_whatever_was_computed_before(tmp_path: Path, n_receivers: int) -> None:
    result = drop_result(rate_hz=1000.0, n_receivers=n_receivers)
    write_tables(result, tmp_path / "ok")
    write_tables(
        replace(result, status="rejected", findings=(as_stored("receiver 1: constants", "refuse"),)),
        tmp_path / "rejected",
    )
    tables = {
        name: np.genfromtxt(tmp_path / name / "track.csv", delimiter=",", names=True) for name in ("ok", "rejected")
    }
    assert tables["ok"]["valid"].all()
    assert not tables["rejected"]["valid"].any()
    assert len(tables["ok"]) == len(tables["rejected"]) == 1600


def test_a_path_that_was_lost_goes_on_as_another_piece(tmp_path: Path) -> None:
    result = drop_result(rate_hz=1000.0, n_receivers=1)
    assert result.paths is not None
    change, piece = result.paths.change_m.copy(), np.zeros(1600, dtype=np.intp)
    change[:, 700:800] = np.nan
    piece[800:], piece[1200:] = 1, 2
    excerpt = Excerpt(first_stored=100, last_stored=1700, first_index=100, of_samples=2000, reason="long")
    result = replace(
        result,
        recording=replace(result.recording, excerpt=excerpt),
        paths=replace(result.paths, change_m=change, piece=piece),
    )
    write_tables(result, tmp_path)
    rows = np.genfromtxt(tmp_path / "track.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(rows["piece"], np.repeat([0, 1, 2], [900, 400, 700]))
    np.testing.assert_array_equal(np.isnan(rows["u_L1_m"]), np.isnan(rows["L1_m"]))
    assert np.flatnonzero(np.isnan(rows["L1_m"])).tolist() == [*range(100), *range(800, 900), *range(1700, 2000)]


@pytest.mark.parametrize("n_receivers", [1, 2])
def test_fewer_than_three_receivers_have_no_position_and_no_bounce(tmp_path: Path, n_receivers: int) -> None:
    write_tables(drop_result(rate_hz=1000.0, n_receivers=n_receivers), tmp_path)
    lengths = [f"L{number}_m" for number in range(1, n_receivers + 1)]
    rows = read_csv(tmp_path / "track.csv")
    assert rows[0] == ["time_s", *lengths, "valid", "piece", *(f"u_{name}" for name in lengths)]
    assert len(rows) == 1601
    assert rows[-1][n_receivers + 1] == "1"
    assert (tmp_path / "bounces.csv").read_text(encoding="utf-8") == BOUNCES + "\n"


def test_the_result_document_says_what_was_used_and_never_nan(tmp_path: Path) -> None:
    result = drop_result(rate_hz=1000.0)
    assert result.corrected is not None
    odd = replace(result.corrected.channels[0], snr_db=math.nan, fringes=math.inf)
    channels = (odd, *result.corrected.channels[1:])
    result = replace(result, corrected=replace(result.corrected, channels=channels))
    write_tables(result, tmp_path)
    document = strict_json(tmp_path / "result.json")
    assert list(document) == KEYS
    assert document["version"] == __version__
    assert document["correction_used"] == "published"
    assert document["geometry_used"] == "exact"
    assert document["free_fall"]["g_m_s2"] == pytest.approx(9.8123)
    assert document["free_fall"]["u_g_m_s2"] == pytest.approx(0.0034)
    assert document["setup"]["schema"] == 1
    assert len(document["setup"]["receiver"]) == 3
    assert document["channels"][0]["snr_db"] is None
    assert document["channels"][0]["fringes"] is None
    assert document["channels"][1]["snr_db"] == pytest.approx(41.3)
    assert document["reason"] is None


def test_the_air_that_a_setup_tells_is_written_with_what_follows_from_it(tmp_path: Path) -> None:
    result = drop_result(rate_hz=1000.0)
    air = {"temperature_c": 20.0, "pressure_hpa": 1013.25, "humidity_percent": 50.0}
    setup = changed(result.setup, radar={"refractive_index": None}, air=air)
    write_tables(replace(result, setup=setup), tmp_path)
    written = strict_json(tmp_path / "result.json")["air"]
    assert written["refractive_index"] == pytest.approx(1.00031923, abs=1e-8)
    assert written["u_density_kg_m3"] == pytest.approx(setup.air.gas.u_density_kg_m3)
    said = repr(setup_blocks(setup))
    assert "20 °C, 1013.25 hPa, 50 % humidity: n − 1 = (319.2 ± 5.2) ppm" in said
    # of air that nobody told nothing is said but what the wave is taken for
    assert "humidity" not in repr(setup_blocks(result.setup))


def test_the_first_fall_is_written_as_measured_with_its_check_against_the_site_beside_it(tmp_path: Path) -> None:
    result = drop_result(rate_hz=1000.0)
    write_tables(result, tmp_path)
    assert strict_json(tmp_path / "result.json")["free_fall"]["site"] is None
    somewhere = changed(result.setup, site={"latitude_deg": 45.0, "height_m": 0.0})
    write_tables(replace(result, setup=somewhere), tmp_path)
    fall = strict_json(tmp_path / "result.json")["free_fall"]
    assert fall["g_m_s2"] == pytest.approx(9.8123)
    assert fall["site"]["site_g_m_s2"] == pytest.approx(9.80620, abs=1e-5)
    assert fall["site"]["difference_m_s2"] == pytest.approx(fall["g_m_s2"] - fall["site"]["expected_m_s2"])
    assert "normal gravity at 45" in fall["site"]["compared"]


def test_lost_samples_keep_their_place_in_time(tmp_path: Path) -> None:
    from radargui.model.recording import Gap

    write_tables(drop_result(rate_hz=1000.0, gap=Gap(900, 30)), tmp_path)
    rows = read_csv(tmp_path / "track.csv")
    assert float(rows[900][0]) == pytest.approx(0.899)
    assert float(rows[901][0]) == pytest.approx(0.930)


def test_a_folder_that_cannot_be_written_is_told_in_plain_words(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.raises(FileError, match="cannot be written: a part of its path is a file") as told:
        write_tables(quiet_result(), tmp_path / "file")
    assert "disk" not in str(told.value)


def test_a_folder_that_is_write_protected_is_not_called_a_full_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def denied(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    result = quiet_result()
    # the file is written under another name first
    monkeypatch.setattr(Path, "replace", denied)
    with pytest.raises(FileError, match=r"Permission denied\. Likely: the folder is write protected;") as told:
        write_tables(result, tmp_path)
    assert "disk" not in str(told.value)


def test_a_table_that_fails_half_way_leaves_the_old_one(tmp_path: Path) -> None:
    write_tables(quiet_result(), tmp_path)
    before = (tmp_path / "track.csv").read_bytes()
    result = drop_result(rate_hz=1000.0)
    assert result.paths is not None
    short = replace(result.paths, piece=np.zeros(10, dtype=np.intp))
    with pytest.raises(ValueError, match="dimensions"):
        write_tables(replace(result, paths=short), tmp_path)
    assert (tmp_path / "track.csv").read_bytes() == before
    assert not list(tmp_path.glob("*.part"))


def test_a_long_recording_has_one_row_a_sample_though_only_an_excerpt_was_processed(tmp_path: Path) -> None:
    whole = drop_result()
    n = whole.recording.n_samples
    excerpt = Excerpt(first_stored=700, last_stored=700 + n, first_index=700, of_samples=n + 1000, reason="long")
    write_tables(replace(whole, recording=replace(whole.recording, file_time_s=None, excerpt=excerpt)), tmp_path)
    rows = np.genfromtxt(tmp_path / "track.csv", delimiter=",", names=True)
    rate = whole.recording.digitisation.sample_rate_hz
    assert rows.size == n + 1000
    assert rows["time_s"] == pytest.approx(np.arange(n + 1000) / rate, abs=1e-9)
    assert not rows["valid"][:700].any()
    assert not rows["valid"][700 + n :].any()
    assert np.isnan(rows["z_m"][:700]).all()
    assert np.isfinite(rows["z_m"][rows["valid"] == 1]).all()
    assert rows["valid"].any()
