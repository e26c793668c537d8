"""What a round of circles hands to the next: counts of fringes, lengths of maps, functions carried over."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import ANTENNAS, BOUNCE_S, CONSTANTS, RELEASE_M, positions, small_problem

from radargui.conditioning.ellipse import Ellipse
from radargui.estimation.adaptive.circle_data import averaging_loss
from radargui.estimation.adaptive.circle_layout import CircleLayout
from radargui.estimation.adaptive.foretold import foretold_round, unwound_round
from radargui.estimation.adaptive.rounds import (
    Round,
    first_round,
    moved_round,
    next_round,
    recounted_round,
    refined,
    still_round,
    stride_of,
)
from radargui.estimation.forward.bins import BinnedData
from radargui.geometry.path_length import path_lengths, range_factor

ELLIPSES = tuple(
    Ellipse(c.offset_i, c.offset_q, np.exp(c.log_amplitude), np.exp(c.log_gain), c.quadrature_error_rad)
    for c in CONSTANTS
)


def seen(**given: Any) -> tuple[BinnedData, np.ndarray]:
    """Return bins of a small problem and the phases that they truly have, zero at rest."""
    data = small_problem(sigma=0.005, lobe=0.0, **given).data
    change = path_lengths(positions(data.bins.time_s), ANTENNAS) - path_lengths(RELEASE_M[:, None], ANTENNAS)
    return data, 2.0 * np.pi * change / data.wavelength_m


@pytest.fixture(scope="module")
def mapped() -> tuple[BinnedData, Round]:
    data, phase = seen()
    return data, next_round(data, first_round(data, still_round(data, ELLIPSES, phase)), 0.15)


def test_still_ellipses_have_the_phases_of_channels_that_came_later_too_and_never_win() -> None:
    (data, phase), (at_once, _) = seen(delay_s=1e-4), seen()
    still, plain = still_round(data, ELLIPSES, phase), still_round(at_once, ELLIPSES, phase)
    assert still.log_evidence == -np.inf
    assert still.holds_count
    # brought to one time they show what channels without delays do, but for an amplitude that goes with the range
    smooth = np.abs(data.bins.time_s - BOUNCE_S) > 0.005
    before, after = (np.std((one - at_once.bins.value)[:, smooth], axis=1) for one in (data.bins.value, still.value))
    assert (after[1:] < 0.5 * before[1:]).all()
    assert still.phase_rad[:, smooth] == pytest.approx(plain.phase_rad[:, smooth], abs=0.2)


def test_so_many_bins_choose_as_leave_six_hundred() -> None:
    strides: dict[int, int] = {}
    for n_bins in (100, 2999, 3000, 6599, 6600, 100000):
        data: Any = SimpleNamespace(bins=SimpleNamespace(n_bins=n_bins))
        strides[n_bins] = stride_of(data)
    assert strides == {100: 1, 2999: 1, 3000: 5, 6599: 7, 6600: 11, 100000: 29}


def test_a_new_count_keeps_the_places_where_its_maps_are_right(mapped: tuple[BinnedData, Round]) -> None:
    data, one = mapped
    lost = one.phase_rad.copy()
    lost[0, 120:] -= 2.0 * np.pi
    before = replace(one, place=one.place + 0.01, made_from=None)
    again = recounted_round(data, replace(one, phase_rad=lost, made_from=before))
    assert again.phase_rad == pytest.approx(one.phase_rad, abs=1e-9)
    assert again.place == pytest.approx(one.place, abs=1e-9)
    # maps were fitted at the places of the round before; of one that has none before at its own
    assert again.fitted_m is before.place
    alone = replace(one, phase_rad=lost, made_from=None)
    assert recounted_round(data, alone).fitted_m is alone.place


def test_a_round_at_other_times_is_the_same_round(mapped: tuple[BinnedData, Round]) -> None:
    data, one = mapped
    later = replace(data, bins=replace(data.bins, time_s=data.bins.time_s + 5e-4))
    moved = moved_round(later, replace(one, made_from=one), data.bins.time_s)
    at = slice(40, 90)
    for name in ("phase_rad", "place", "amplitude"):
        was, found = getattr(one, name)[:, at], getattr(moved, name)[:, at]
        step = np.diff(getattr(one, name)[:, 40:91], axis=1) * 5e-4 / np.diff(data.bins.time_s[40:91])
        assert found == pytest.approx(was + step)
    assert moved.made_from is None
    assert moved.value is later.bins.value


def test_a_round_of_few_bins_is_refined_on_all_and_one_of_all_stays(mapped: tuple[BinnedData, Round]) -> None:
    data, one = mapped
    assert refined(data, one) is one
    before = first_round(data, still_round(data, ELLIPSES, seen()[1]))
    thin = next_round(data, before, 0.15, 5)
    assert thin.stride == 5
    whole = refined(data, thin)
    assert whole.stride == 1
    assert whole.bias is thin.bias
    # five times as many bins say more of each number
    for few, all_of_them in zip(thin.fits, whole.fits, strict=True):
        u = [np.sqrt(np.diag(fit.covariance)[CircleLayout.front_end]) for fit in (few, all_of_them)]
        assert (u[1] < 0.7 * u[0]).all()
    for lacks in ("made_from", "bias", "amplitude_map"):
        bare = replace(thin, **{lacks: None})
        assert refined(data, bare) is bare


def test_constants_hold_the_mean_of_the_bias_and_the_amplitude_at_rest(mapped: tuple[BinnedData, Round]) -> None:
    _, one = mapped
    assert one.bias is not None
    for n, (fit, constants) in enumerate(zip(one.fits, one.receiver_constants(), strict=True)):
        mean = fit.centre(one.bias(one.place)).mean(axis=1)
        assert (constants.offset_i, constants.offset_q) == pytest.approx(tuple(mean))
        assert constants.log_amplitude == pytest.approx(np.log(one.amplitude[n, 0]))
        assert constants.phase_rad == one.rest_phase_rad[n]


def test_of_a_receiver_whose_phase_is_foretold_amplitude_phase_and_centre_are_left_to_find(
    mapped: tuple[BinnedData, Round],
) -> None:
    data, one = mapped
    up = np.array([0.0, 0.0, 1.0])
    lost = one.phase_rad.copy()
    lost[1] = np.clip(lost[1], -4.0, 4.0)
    first = foretold_round(data, replace(one, phase_rad=lost), up)
    # samples that show just what is foretold, on a circle of their own
    shape = range_factor(first.place, ANTENNAS, RELEASE_M)[1] * averaging_loss(first.phase_rad, data.bins)[1]
    wave, value = 0.7 * shape * np.exp(1j * (first.phase_rad[1] + 0.4)), one.value.copy()
    value[2], value[3] = 0.3 + wave.real, -0.2 + wave.imag
    found = foretold_round(data, replace(one, phase_rad=lost, value=value), up)
    assert found.phase_rad[1] == pytest.approx(first.phase_rad[1])
    assert found.amplitude[1] == pytest.approx(0.7 * shape)
    assert found.rest_phase_rad[1] == pytest.approx(0.4)
    fit = found.fits[1].ellipse
    assert (fit.i0_v, fit.q0_v, fit.amplitude_v) == pytest.approx((0.3, -0.2, 0.7))
    assert (fit.gain_ratio, fit.quadrature_error_rad) == (1.0, 0.0)
    # of the others nothing is changed
    for n in (0, 2):
        assert found.fits[n] is one.fits[n]
        assert found.amplitude[n].tolist() == one.amplitude[n].tolist()


@pytest.mark.parametrize(("turns", "winds"), [(1.9, False), (2.1, True)])
def test_who_counts_two_turns_winds(mapped: tuple[BinnedData, Round], turns: float, winds: bool) -> None:
    data, one = mapped
    phase = one.phase_rad.copy()
    phase[2] = np.linspace(0.0, 2.0 * np.pi * turns, phase.shape[1])
    assert (unwound_round(data, replace(one, phase_rad=phase)) is None) is winds
