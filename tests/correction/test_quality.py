"""Quality of a corrected signal against figures that follow from how it was made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radargui.correction.quality import LIMITS, assess, circularity, image_rejection_db, judge
from radargui.model.channel_quality import ChannelQuality

PHASES = {
    "steady": np.linspace(0.0, 2 * np.pi * 60, 20000),
    "ever faster": 2 * np.pi * 60 * np.linspace(0.1, 1.0, 20000) ** 2,
}


@pytest.mark.parametrize("motion", PHASES)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("rejection_db", [15.0, 30.0, 45.0])
def test_an_image_of_known_size_is_found(motion: str, sign: int, rejection_db: float) -> None:
    phase = sign * PHASES[motion]
    z = np.exp(1j * phase) + 10.0 ** (-rejection_db / 20.0) * np.exp(-1j * phase + 0.7j)
    z = z + 0.003 * np.random.default_rng(0).normal(size=(2, phase.size)).T.copy().view(np.complex128)[:, 0]
    found = image_rejection_db(np.stack([z.real, z.imag]), np.unwrap(np.angle(z)))
    assert found == pytest.approx(rejection_db, abs=1.5)


def test_a_short_motion_has_no_image_rejection() -> None:
    phase = np.linspace(0.0, 2 * np.pi * 3, 2000)
    assert image_rejection_db(np.stack([np.cos(phase), np.sin(phase)]), phase) is None


def test_circularity_is_the_spread_of_the_radius_within_a_fringe() -> None:
    phase = np.linspace(0.0, 300.0, 20000)
    radius = 1.0 + 0.1 * np.sin(7 * phase)
    assert circularity(radius * np.stack([np.cos(phase), np.sin(phase)]), phase) == pytest.approx(
        0.1 / np.sqrt(2), rel=0.03
    )


def test_an_echo_that_grows_fivefold_along_the_way_stays_round() -> None:
    phase = np.linspace(0.0, 300.0, 20000)
    assert circularity(np.linspace(0.4, 2.0, 20000) * np.stack([np.cos(phase), np.sin(phase)]), phase) < 0.03


def test_an_offset_is_not_round() -> None:
    turn = np.linspace(0.0, 300.0, 20000)
    z = np.exp(1j * turn) + 0.3
    assert circularity(np.stack([z.real, z.imag]), np.unwrap(np.angle(z))) == pytest.approx(0.3 / np.sqrt(2), rel=0.1)


GOOD = ChannelQuality("1", circularity=0.02, fringes=9.0, fraction_valid=1.0, fraction_clipped=0.0)
NOISE = 0.01
"""Far below every limit."""


def beyond(limit: float) -> float:
    """The circularity that leaves this beyond the noise."""
    return float(np.hypot(limit, NOISE))


@pytest.mark.parametrize(
    ("changed", "counted_noise", "misfit", "verdict", "words"),
    [
        ({}, NOISE, None, "good", ""),
        ({}, 1.01 * LIMITS.good_noise, None, "usable", "low signal-to-noise"),
        ({}, 1.01 * LIMITS.max_noise, None, "rejected", "fringes cannot be counted"),
        ({"circularity": beyond(1.01 * LIMITS.good_circularity)}, NOISE, None, "usable", "leave the circle"),
        ({"circularity": beyond(1.01 * LIMITS.max_circularity)}, NOISE, None, "rejected", "leave the circle"),
        ({}, NOISE, 1.01 * LIMITS.good_misfit, "usable", "uncertainties are widened"),
        ({}, NOISE, 100.0 * LIMITS.max_misfit, "usable", "uncertainties are widened"),
        ({"circularity": beyond(0.99 * LIMITS.max_circularity)}, NOISE, 100.0, "usable", "leave the circle"),
        ({"fringes": 0.99}, NOISE, None, "usable", "less than one fringe"),
        ({"fraction_valid": 0.89}, NOISE, None, "usable", "89 % of the samples are valid"),
        ({"fraction_clipped": 0.002}, NOISE, None, "usable", "0.2 % of the samples are clipped or left out"),
    ],
)
def test_each_limit_parts_two_verdicts(
    changed: dict[str, float | None], counted_noise: float, misfit: float | None, verdict: str, words: str
) -> None:
    found = replace(GOOD, finding=judge(replace(GOOD, **changed), NOISE, counted_noise, misfit))
    assert found.verdict == verdict
    assert words in found.reason
    assert bool(found.reason) == (verdict != "good")


@pytest.mark.parametrize("limit", [LIMITS.good_circularity, LIMITS.max_circularity])
def test_a_weak_signal_is_said_before_the_circle_that_its_noise_leaves(limit: float) -> None:
    noise = 1.01 * LIMITS.good_noise
    bent = replace(GOOD, circularity=float(np.hypot(1.01 * limit, noise)))
    weak = judge(bent, noise, noise, None)
    assert weak is not None
    assert weak.text.startswith("low signal-to-noise ratio, and corrected I and Q leave the circle by ")
    # by its samples alone, too, however many are taken together
    assert judge(bent, noise, NOISE, None) == weak
    strong = judge(replace(GOOD, circularity=beyond(1.01 * limit)), NOISE, NOISE, None)
    assert strong is not None
    assert strong.text.startswith("corrected I and Q leave the circle by ")


@pytest.mark.parametrize(
    ("gain", "angle_deg", "verdict"),
    [
        (1.6, 35.0, "good"),
        (0.6, -35.0, "good"),
        (2.01, 0.0, "rejected"),
        (0.49, 0.0, "rejected"),
        (1.0, 42.5, "rejected"),
        (1.0, -60.0, "rejected"),
    ],
)
def test_a_front_end_that_no_mixer_has_is_refused(gain: float, angle_deg: float, verdict: str) -> None:
    found = replace(
        GOOD, finding=judge(replace(GOOD, gain_ratio=gain, quadrature_error_deg=angle_deg), NOISE, NOISE, 1.0)
    )
    assert found.verdict == verdict
    assert ("no mixer" in found.reason) == (verdict == "rejected")


def assessed(iq: np.ndarray, phase: np.ndarray, **more: object) -> ChannelQuality:
    valid = np.ones(phase.size, dtype=np.bool_)
    values: dict[str, object] = {"valid": valid, "noise": NOISE, "fraction_clipped": 0.0, **more}
    return assess("1", iq=iq, phase_rad=phase, **values)  # type: ignore[arg-type]


def test_what_is_assessed_is_what_was_made() -> None:
    phase = np.linspace(0.0, 2 * np.pi * 40, 20000)
    noise = NOISE * np.random.default_rng(0).normal(size=(2, phase.size))
    circle = np.stack([np.cos(phase), np.sin(phase)]) + noise
    found = assessed(circle, phase, gain_ratio=1.1)
    assert found.verdict == "good"
    assert found.fringes == pytest.approx(40.0, rel=0.01)
    assert found.snr_db == pytest.approx(10 * np.log10(0.5 / NOISE**2))
    assert found.circularity == pytest.approx(NOISE, rel=0.1)
    assert found.gain_ratio == 1.1


def test_an_echo_that_grows_is_round_unless_the_correction_rescaled_it() -> None:
    phase = np.linspace(0.0, 2 * np.pi * 40, 20000)
    grows = np.linspace(0.4, 1.6, phase.size) * np.stack([np.cos(phase), np.sin(phase)])
    assert assessed(grows, phase).verdict == "good"
    assert assessed(grows, phase, rescaled=True).verdict == "usable"


def test_invalid_samples_do_not_count_and_without_any_valid_one_nothing_is_round() -> None:
    phase = np.linspace(0.0, 2 * np.pi * 40, 20000)
    circle = np.stack([np.cos(phase), np.sin(phase)])
    circle[:, :1000] *= 9.0
    valid = np.arange(phase.size) >= 1000
    assert assessed(circle, phase, valid=valid).verdict == "good"
    nothing = assessed(circle, phase, valid=np.zeros_like(valid))
    assert nothing.verdict == "rejected"
    assert nothing.circularity is None


def test_noise_is_judged_where_the_fringes_are_counted() -> None:
    phase = np.linspace(0.0, 2 * np.pi * 40, 20000)
    circle = np.stack([np.cos(phase), np.sin(phase)])
    assert assessed(circle, phase, noise=0.6).verdict == "rejected"
    assert assessed(circle, phase, noise=0.6, counted_noise=0.1).verdict == "good"
