"""Setups for quick tests: the shipped one at a low rate, and one receiver that looks at a plate."""

from __future__ import annotations

from radargui.model.setup import Setup, changed, read_setup
from radargui.system.resources import default_setup_path

E = 0.6
"""Coefficient of restitution of the quick setups."""

PLATE = """\
# 9 GHz homodyne radar: one antenna sends and receives, the plate moves on its axis
schema = 1
[radar]
frequency_hz = 9.0e9
[transmitter]
distance_m = 2.0
[[receiver]]
tilt_deg = 0.0
azimuth_deg = 0.0
distance_m = 2.0
[processing]
correction = "published"
"""


def quick_setup() -> Setup:
    """Return the default setup with the published correction, for tests that do not need the estimates.

    The sphere bounces half as often: each flight costs as much as the others.
    """
    values = {"processing.correction": "published", "simulation.restitution": E}
    return changed(read_setup(default_setup_path()), values)


def small_setup_text() -> str:
    """Return the default setup at 4 kHz without multiplexer, with the quick correction, few bounces, early ends."""
    text = default_setup_path().read_text(encoding="utf-8")
    text = text.replace("rate_hz = 33333.0", "rate_hz = 4000.0").replace("channel_skew_s = 5.0e-6", "")
    text = text.replace('correction = "joint"', 'correction = "published"')
    text = text.replace("restitution = 0.8", f"restitution = {E}")
    return f"{text}\n[recording]\nquiet_s = 0.2\nmaximum_s = 4.0\n"
