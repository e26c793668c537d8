"""A bad setup gives one clear line: key, value, allowed range."""

from __future__ import annotations

import pytest

from radargui.model.errors import SetupError
from radargui.model.setup import parse_setup

GOOD = """\
schema = 1
[radar]
frequency_hz = 10.0e9
[transmitter]
distance_m = 0.70
[[receiver]]
tilt_deg = 40.0
azimuth_deg = 90.0
distance_m = 0.71
"""


def line_of(text: str) -> str:
    with pytest.raises(SetupError) as caught:
        parse_setup(text, "lab.toml")
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith("lab.toml")
    return line


def changed(old: str, new: str) -> str:
    assert GOOD.count(old) == 1
    return GOOD.replace(old, new)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            GOOD.split("[[receiver]]", maxsplit=1)[0],
            "[[receiver]] is missing, allowed: 1 to 4 tables, each headed [[receiver]]",
        ),
        (
            changed("[[receiver]]", "[receiver]"),
            (
                "receiver = {tilt_deg = 40.0, azimuth_deg = 90.0, distance_m = 0.71}, "
                "allowed: 1 to 4 tables, each headed [[receiver]]"
            ),
        ),
        (
            changed("tilt_deg = 40.0", "tilt_deg = 400.0"),
            "receiver[1].tilt_deg = 400.0, allowed: a number from 0 to 180",
        ),
        (changed("tilt_deg = 40.0", "tilt_deg = nan"), "receiver[1].tilt_deg = nan, allowed: a number from 0 to 180"),
        (changed("tilt_deg = 40.0", "tilt_deg = true"), "receiver[1].tilt_deg = true, allowed: a number from 0 to 180"),
        (changed("10.0e9", "inf"), "radar.frequency_hz = inf, allowed: a number from 1e8 to 1e12"),
        (
            changed("[transmitter]\ndistance_m = 0.70", ""),
            (
                "[transmitter] is missing, allowed: a table with distance_m, u_distance_m, phase_centre_m, "
                "u_phase_centre_m, u_x_m, u_y_m, position_m, "
                "polarization_deg, u_polarization_deg"
            ),
        ),
        (GOOD + "[daq]\nchannels = ['ai0']", 'daq.channels = ["ai0"], allowed: a list of 2 to 8 texts'),
        (
            GOOD + "[daq]\nchannels = ['ai0', 'ai1', 'ai2']",
            "daq.channels names 3 channels: allowed 2 for 1 [[receiver]] (I1, Q1)",
        ),
        (
            GOOD + "[daq]\nremote = 'somewhere'",
            'daq.remote = "somewhere", allowed: a text HOST:PORT with a port of 1 to 65535',
        ),
        (GOOD + "[daq]\ndevice = ''", 'daq.device = "", allowed: a text, not empty'),
        (
            GOOD + "[daq]\nterminal = 'single'",
            'daq.terminal = "single", allowed: differential, rse, nrse, pseudodifferential, default',
        ),
        (GOOD + "[simulation]\nnoise = 1", "simulation.noise = 1, allowed: true or false"),
        (
            GOOD + "[tracer]\nrelease_position_m = [0, 0, 20]",
            "tracer.release_position_m[3] = 20, allowed: a number from -10 to 10",
        ),
        (GOOD + "[floor]\nnormal = [0, 0, 0]", "floor.normal = [0, 0, 0], allowed: any direction, not the zero vector"),
        (
            GOOD + "tilt = 3",
            (
                "receiver[1].tilt = 3: unknown key (did you mean tilt_deg?), allowed here: tilt_deg, azimuth_deg, "
                "distance_m, polarization_deg, u_tilt_deg, u_azimuth_deg, u_distance_m, phase_centre_m, "
                "u_phase_centre_m, u_polarization_deg"
            ),
        ),
        (
            "tracer = 3\n" + GOOD,
            (
                "tracer = 3, allowed: a table with diameter_m, u_diameter_m, material, refractive_index, "
                "u_refractive_index, holder_distance_m, density_kg_m3, release_position_m, "
                "u_release_m, u_release_scatter_m"
            ),
        ),
    ],
)
def test_a_bad_setting_gives_one_line_with_key_value_and_allowed_range(text: str, line: str) -> None:
    assert line_of(text) == f"lab.toml: {line}"


@pytest.mark.parametrize("value", ["2", "0", "true", "1.0", '"1"', "[1]"])
def test_another_schema_is_refused_by_name(value: str) -> None:
    assert (
        line_of(changed("schema = 1", f"schema = {value}")) == f"lab.toml: schema = {value}, allowed: 1 in this version"
    )


def test_a_missing_schema_is_named() -> None:
    assert line_of(changed("schema = 1", "")) == "lab.toml: schema is missing, allowed: 1 in this version"


def test_another_schema_is_told_before_what_follows_from_it() -> None:
    line = line_of(changed("schema = 1", "schema = 2\nlaser = 3"))
    assert line == "lab.toml: schema = 2, allowed: 1 in this version (and 1 more fault)"


def test_a_mistyped_key_is_told_before_the_key_that_is_missing_because_of_it() -> None:
    line = line_of(changed("[[receiver]]", "[[reciever]]"))
    assert "unknown key (did you mean receiver?)" in line
    assert line.endswith("(and 1 more fault)")


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("this is a letter", "Expected '=' after a key in a key/value pair (at line 1, column 6)"),
        (GOOD + "[radar]\n", "twice (at line 10, column 7)"),
        ("x = " + 5000 * "[", "nested too deep"),
        ("x = 1" + 5000 * "0", "a number has too many digits"),
        ("x = '''one\ntwo", "Expected"),
        ("\x00", "Invalid statement"),
    ],
)
def test_what_is_not_toml_is_called_so_with_its_place(text: str, fault: str) -> None:
    line = line_of(text)
    assert line.startswith("lab.toml is not TOML: ")
    assert fault in line
    assert line.endswith("Correct that place or start from a shipped setup.")


def test_a_long_or_many_lined_value_is_cut_to_one_short_line() -> None:
    line = line_of(GOOD + '[daq]\ndevice = ["""' + 50 * "a\nb" + '"""]')
    assert len(line) < 150
    assert "..., allowed: a text, not empty" in line
