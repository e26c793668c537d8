"""What a round of circles hands to the next: counts of fringes, lengths of maps, functions carried over."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import ANTENNAS, BOUNCE_S, CONSTANTS, RELEASE_M, START_S, positions, small_problem

from radargui.estimation.adaptive import found as found_module, rounds
from radargui.estimation.adaptive.circle_data import averaging_loss
from radargui.estimation.adaptive.circle_layout import CircleLayout
from radargui.estimation.adaptive.foretold import foretold_round, unwound_round
from radargui.estimation.adaptive.found import (
    START,
    AdaptiveRounds,
    _counts_otherwise,
    _fastest_m_s,
    _recounted,
    _turns,
)
from radargui.estimation.adaptive.rough import RoughPhases
from radargui.estimation.adaptive.rounds import (
    MAP_ROUNDS,
    Round,
    _carried,
    _phases,
    _shortest_m,
    _time_functions,
    best_round,
    first_round,
    moved_round,
    next_round,
    quick_round,
    recounted_round,
    refined,
    still_round,
    stride_of,
)
from radargui.estimation.adaptive.still_ellipse import StillEllipse
from radargui.estimation.forward.bins import BinnedData
from radargui.estimation.forward.position_map import make_basis
from radargui.geometry.path_length import path_lengths, range_factor

ELLIPSES = tuple(
    StillEllipse(c.offset_i, c.offset_q, c.log_gain, c.quadrature_error_rad, float(np.exp(c.log_amplitude)))
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


def test_no_map_is_shorter_than_extents_a_fringe(mapped: tuple[BinnedData, Round]) -> None:
    _, one = mapped
    extent = np.linalg.norm(one.place.max(axis=1) - one.place.min(axis=1))
    turns = (one.phase_rad.max(axis=1) - one.phase_rad.min(axis=1)).max() / (2.0 * np.pi)
    assert turns > 5.0
    assert _shortest_m(one) == pytest.approx(1.5 * extent / turns)
    # of less than a fringe the extent itself
    assert _shortest_m(replace(one, phase_rad=0.01 * one.phase_rad)) == pytest.approx(1.5 * extent)


@pytest.mark.parametrize(
    ("shortest_m", "evidence", "tried", "kept"),
    [
        (0.01, {0.06: 4.0, 0.09: 3.0, 0.13: 2.0, 0.20: 1.0}, [0.20, 0.13, 0.09, 0.06], 0.06),
        # the longest first, until it falls
        (0.01, {0.06: 9.0, 0.09: 1.0, 0.13: 2.0, 0.20: 1.0}, [0.20, 0.13, 0.09], 0.13),
        (0.10, {0.06: 4.0, 0.09: 3.0, 0.13: 2.0, 0.20: 1.0}, [0.20, 0.13], 0.13),
        (0.30, {0.30: 1.0}, [0.30], 0.30),
    ],
)
def test_the_evidence_chooses_a_length_among_those_that_cannot_follow_the_wave(
    monkeypatch: pytest.MonkeyPatch,
    mapped: tuple[BinnedData, Round],
    shortest_m: float,
    evidence: dict[float, float],
    tried: list[float],
    kept: float,
) -> None:
    data, one = mapped
    asked: list[float] = []

    def maps(binned: BinnedData, before: Round, length_m: float, stride: int) -> Any:
        asked.append(length_m)
        return SimpleNamespace(log_evidence=evidence[length_m], length_m=length_m)

    monkeypatch.setattr(rounds, "_shortest_m", lambda before: shortest_m)
    monkeypatch.setattr(rounds, "_maps", maps)
    monkeypatch.setattr(rounds, "_round_of_maps", lambda binned, before, best, stride: best)
    found: Any = best_round(data, one)
    assert (asked, found.length_m) == (tried, kept)
    asked.clear()
    evidence[max(shortest_m, MAP_ROUNDS.quick_length_m)] = 0.0
    quick_round(data, one, 1)
    assert asked == [max(shortest_m, 0.13)]


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


def test_maps_on_the_functions_that_they_have_are_carried_as_they_are(mapped: tuple[BinnedData, Round]) -> None:
    data, one = mapped
    assert one.bias is not None
    assert one.amplitude_map is not None
    functions = one.bias(one.place), one.amplitude_map(one.place)
    own: Any = SimpleNamespace(layout=one.fits[0].layout, bias=functions[0], amplitude_map=functions[1])
    for start, fit in zip(_carried(one, [own] * 3, one.place), one.fits, strict=True):
        assert start[CircleLayout.constants].tolist() == fit.theta[CircleLayout.constants].tolist()
        # values go over; weak functions may share them otherwise
        for at, places in ((0, fit.layout.bias_i), (0, fit.layout.bias_q), (1, fit.layout.amplitude_map)):
            assert functions[at] @ start[places] == pytest.approx(functions[at] @ fit.theta[places], abs=1e-3)
    # other functions: the nearest that they can say
    basis = make_basis(one.place[:, ~data.rest], 0.3)
    wide = basis(one.place)
    layout = CircleLayout(wide.shape[1], functions[1].shape[1])
    other: Any = SimpleNamespace(layout=layout, bias=wide, amplitude_map=functions[1])
    for start, fit in zip(_carried(one, [other] * 3, one.place), one.fits, strict=True):
        said = functions[0] @ fit.theta[fit.layout.bias_q]
        nearest = wide @ np.linalg.lstsq(wide, said, rcond=None)[0]
        assert wide @ start[layout.bias_q] == pytest.approx(nearest, abs=1e-3)
        assert start[layout.constants].tolist() == fit.theta[fit.layout.constants].tolist()
    bare = replace(one, bias=None)
    assert not _carried(bare, [own] * 3, one.place)[0][own.layout.bias].any()


def test_phases_count_from_the_mean_direction_at_rest_or_else_from_the_first_point() -> None:
    bins: Any = SimpleNamespace(time_s=np.linspace(0.0, 1.0, 9))
    angle = np.array([0.3, 0.1, 0.2, 0.9, 2.0, 3.5, 5.0, 7.0, 9.0])
    points = [np.array([2.0 * np.cos(angle), 2.0 * np.sin(angle)])]
    rest = np.arange(9) < 3
    phase, at_rest = _phases(points, bins, rest)
    assert at_rest == pytest.approx([0.2], abs=1e-3)
    assert phase[0] == pytest.approx(angle - at_rest[0])
    phase, at_rest = _phases(points, bins, np.zeros(9, bool))
    assert at_rest == pytest.approx([0.3])
    assert phase[0] == pytest.approx(angle - 0.3)
    # counted before: within half a turn of that, by whole turns from the rest
    counted = np.array([angle + 20.0 * np.pi + np.where(np.arange(9) < 6, 0.0, 6.0 * np.pi)])
    phase, _ = _phases(points, bins, rest, counted)
    assert phase[0] == pytest.approx(angle - 0.2 + np.where(np.arange(9) < 6, 0.0, 6.0 * np.pi), abs=1e-3)


def test_an_amplitude_over_time_is_constant_at_rest_and_has_sixteen_bumps_over_the_motion() -> None:
    data, _ = seen()
    functions, time = _time_functions(data), data.bins.time_s
    assert functions.shape == (250, 16)
    assert np.ptp(functions[time < START_S], axis=0) == pytest.approx(0.0, abs=1e-12)
    moving = time[~data.rest]
    step = (moving[-1] - moving[0]) / 15.0
    for k in (0, 7, 15):
        assert functions[~data.rest, k] == pytest.approx(np.exp(-0.5 * ((moving - moving[0]) / step - k) ** 2))


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


def test_phases_count_other_fringes_beyond_two_radians(mapped: tuple[BinnedData, Round]) -> None:
    _, one = mapped
    shifted = one.phase_rad.copy()
    shifted[1, 100] += 1.99
    assert not _counts_otherwise(replace(one, phase_rad=shifted), one)
    shifted[1, 100] -= 2.0 * 1.99 + 0.02
    assert _counts_otherwise(replace(one, phase_rad=shifted), one)
    assert START.other_count_rad == 2.0


def test_of_two_counts_the_one_in_which_the_tracer_jumps_less_is_kept(
    monkeypatch: pytest.MonkeyPatch, mapped: tuple[BinnedData, Round]
) -> None:
    data, one = mapped
    place = one.place.copy()
    # at rest nothing else moves it
    place[:, 5] += [0.003, 0.0, 0.004]
    torn = replace(one, place=place, phase_rad=one.phase_rad + 3.0)
    assert _fastest_m_s(data, torn) == pytest.approx(0.005 / (data.bins.time_s[5] - data.bins.time_s[4]))
    assert _fastest_m_s(data, one) == pytest.approx(9.81 * (BOUNCE_S - START_S), rel=0.1)
    monkeypatch.setattr(found_module, "best_round", lambda binned, other, stride: other)
    for last, other, kept in ((torn, one, one), (one, torn, one)):
        monkeypatch.setattr(found_module, "recounted_round", lambda binned, was, other=other: other)
        assert _recounted(data, last) is kept


def test_sharp_minima_beside_an_impact_or_a_stop_are_these(
    monkeypatch: pytest.MonkeyPatch, mapped: tuple[BinnedData, Round]
) -> None:
    data, one = mapped
    monkeypatch.setattr(found_module, "find_turns", lambda *given: np.array([0.1, 0.2, 0.3, 0.4]))
    monkeypatch.setattr(found_module, "find_stops", lambda *given: np.array([0.4059, 0.35]))
    turns = _turns(data, one, np.array([0.0, 0.0, 1.0]), np.array([0.0941, 0.2061, 0.5]))
    assert turns.tolist() == [0.2, 0.3, 0.35, 0.4059]


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
    assert (fit.offset_i, fit.offset_q, fit.amplitude) == pytest.approx((0.3, -0.2, 0.7))
    assert (fit.log_gain, fit.quadrature_error_rad) == (0.0, 0.0)
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


def test_other_counts_begin_with_the_first_rounds_and_are_each_kept_once(
    monkeypatch: pytest.MonkeyPatch, mapped: tuple[BinnedData, Round]
) -> None:
    data, one = mapped

    def counted(off: float) -> Round:
        return replace(one, phase_rad=one.phase_rad + off)

    # the first round counts otherwise, what is foretold of it as it does, what is foretold of the last a third way
    monkeypatch.setattr(found_module, "first_round", lambda *given: counted(6.0))
    monkeypatch.setattr(
        found_module, "foretold_round", lambda data, last, normal: counted(6.5 if last is not one else -6.0)
    )
    monkeypatch.setattr(found_module, "unwound_round", lambda data, last: counted(12.0))
    monkeypatch.setattr(found_module, "recounted_round", lambda data, last: counted(18.0))
    monkeypatch.setattr(found_module, "best_round", lambda data, other, stride: other)
    rough = RoughPhases(data.bins.time_s, one.phase_rad, np.zeros(250), ELLIPSES, {})
    signals: Any = SimpleNamespace()
    rounds_of = AdaptiveRounds(signals, data, rough, one, np.array([BOUNCE_S]), np.zeros(0))
    others = rounds_of.other_counts(np.array([0.0, 0.0, 1.0]))
    offs = [float((other.last.phase_rad - one.phase_rad)[0, 0]) for other in others]
    assert offs == pytest.approx([6.0, -6.0, 12.0, 18.0])
    # each has the impacts of its own places
    assert all(other.impact_s == pytest.approx([BOUNCE_S], abs=0.003) for other in others)
