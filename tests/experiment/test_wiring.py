"""The wiring check finds swapped channels, inverted Q and dead inputs, and its proposals correct them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from support.changed import changed
from support.miswired import Miswired
from support.ni_samples import ni_setup

from radargui.acquisition.ring import Ring
from radargui.experiment.wiring import WiringGuide
from radargui.model.recording import Block, Digitisation
from radargui.model.setup import Setup
from radargui.model.wiring import wiring_steps
from radargui.processing.wiring import WiringReport
from radargui.sources.contract import ReplaySource
from radargui.sources.simulated.model import WiringScene

RATE_HZ = 2000.0


def scene_setup(receivers: int = 3, **tables: dict[str, Any]) -> Setup:
    return changed(ni_setup(None, receivers, rate_hz=RATE_HZ, read_interval_s=0.5), **tables)


@cache
def scene(receivers: int) -> tuple[Digitisation, np.ndarray]:
    """Return what the operator's samples are where all wires are right, read once for all tests."""
    source = WiringScene(scene_setup(receivers), realtime=False)
    digitisation = source.open()
    source.start()
    blocks = []
    while (block := source.read()) is not None:
        blocks.append(block.samples)
    return digitisation, np.concatenate(blocks, axis=1)


def checked(setup: Setup, wires: Miswired | None = None) -> WiringReport:
    digitisation, samples = scene(setup.n_receivers)
    guide = WiringGuide(setup, digitisation)
    if wires is not None:
        samples = wires.wired(samples)
    guide.push(Block(samples, 0))
    assert guide.is_done
    return guide.report()


def miswired(order: list[int] | None = None, **faults: Any) -> Miswired:
    return Miswired(WiringScene(scene_setup(), realtime=False), order, **faults)


def rewired(report: WiringReport, setup: Setup, wires: Miswired) -> WiringReport:
    """Return what a second check finds after the proposals were taken."""
    corrected = report.corrected(setup)
    places = [setup.physical_channels.index(channel) for channel in corrected.physical_channels]
    digitisation, samples = scene(setup.n_receivers)
    guide = WiringGuide(corrected, digitisation)
    guide.push(Block(wires.wired(samples)[places], 0))
    return guide.report()


@pytest.mark.parametrize("receivers", [1, 2, 3, 4])
def test_right_wires_are_called_right_with_how_far_each_path_length_rose(receivers: int) -> None:
    report = checked(scene_setup(receivers))
    assert report.is_good
    assert not report.corrects
    assert len(report.findings) == receivers
    assert report.findings[-1].sentence.startswith(f"Receiver {receivers}: I{receivers} and Q{receivers} answer to it")
    assert "rises by 0.2" in report.findings[0].sentence


def test_channels_of_two_antennas_that_are_exchanged_are_named_with_their_antenna() -> None:
    wires = miswired([0, 3, 2, 1, 4, 5])
    setup = scene_setup()
    report = checked(setup, wires)
    assert [str(finding) for finding in report.findings if finding.kind == "swapped"] == [
        "Q2 (ai3) belongs to receiver 1. Take the channels proposed.",
        "Q1 (ai1) belongs to receiver 2. Take the channels proposed.",
    ]
    assert report.channels == ("ai0", "ai3", "ai2", "ai1", "ai4", "ai5")
    assert report.settings() == ('daq.channels = ["ai0", "ai3", "ai2", "ai1", "ai4", "ai5"]',)
    assert report.phase_sign is None
    assert rewired(report, setup, wires).is_good


def test_two_antennas_exchanged_as_a_whole_are_found() -> None:
    wires = miswired([4, 5, 2, 3, 0, 1])
    report = checked(scene_setup(), wires)
    assert report.channels == ("ai4", "ai5", "ai2", "ai3", "ai0", "ai1")
    assert "I3 (ai4) and Q3 (ai5) belong to receiver 1." in report.findings[0].sentence


def test_q_inverted_everywhere_is_the_sign_of_the_phase() -> None:
    wires = miswired(inverted=[1, 3, 5])
    report = checked(scene_setup(), wires)
    assert report.phase_sign == -1
    assert report.channels is None
    (told,) = (finding for finding in report.findings if finding.kind == "direction")
    assert str(told) == ("Path lengths fall when the tracer moves away: Q is inverted. Take the phase_sign proposed.")
    assert rewired(report, scene_setup(), wires).is_good


def test_a_setup_with_the_other_sign_is_told_to_turn_it_back() -> None:
    setup = scene_setup(radar={"phase_sign": -1})
    report = checked(setup)
    assert report.phase_sign == 1
    assert report.corrected(setup).radar.phase_sign == 1


def test_one_inverted_q_is_mended_by_exchanging_its_pair() -> None:
    wires = miswired(inverted=[3])
    setup = scene_setup()
    report = checked(setup, wires)
    (told,) = (finding for finding in report.findings if finding.kind == "direction")
    assert told.sentence.startswith("L2 falls where the others do not: I and Q of receiver 2 are exchanged")
    assert report.channels == ("ai0", "ai1", "ai3", "ai2", "ai4", "ai5")
    assert rewired(report, setup, wires).is_good


@pytest.mark.parametrize("channel", range(6))
def test_a_dead_input_is_named_and_the_others_are_judged_all_the_same(channel: int) -> None:
    setup = scene_setup()
    report = checked(setup, miswired(dead=[channel]))
    told = [finding for finding in report.findings if finding.kind != "good"]
    assert [finding.kind for finding in told] == ["dead"]
    assert told[0].sentence == f"{setup.channel_names[channel]} (ai{channel}) does not answer to anything."
    assert told[0].receiver == channel // 2
    assert sum(finding.kind == "good" for finding in report.findings) == 2
    assert report.channels is None


def test_nothing_at_all_is_one_finding() -> None:
    report = checked(scene_setup(), miswired(dead=range(6)))
    assert [finding.kind for finding in report.findings] == ["dead"]
    assert "transmitter" in report.findings[0].remedy


def test_an_input_at_the_end_of_its_range_is_told() -> None:
    def open_input(samples: np.ndarray) -> np.ndarray:
        samples[4] = 32767
        return samples

    report = checked(scene_setup(), miswired(spoil=open_input))
    kinds = {finding.kind: finding for finding in report.findings}
    assert kinds["clipped"].sentence == "I3 (ai4) is at the end of its range 100 % of the time."
    assert "dead" in kinds


def test_i_and_q_from_one_output_are_told() -> None:
    def doubled(samples: np.ndarray) -> np.ndarray:
        samples[1] = samples[0]
        return samples

    report = checked(scene_setup(), miswired(spoil=doubled))
    (told,) = (finding for finding in report.findings if finding.kind != "good")
    assert told.kind == "same"
    assert told.sentence == "I1 and Q1 of receiver 1 carry the same signal."


def test_a_check_in_which_nobody_moved_finds_nothing_alive() -> None:
    setup = scene_setup()
    digitisation, samples = scene(3)
    guide = WiringGuide(setup, digitisation)
    still = np.tile(samples[:, :7000], 20)[:, : samples.shape[1]]
    guide.push(Block(still, 0))
    report = guide.report()
    assert not report.is_good
    assert not report.corrects


def test_waves_that_reach_all_antennas_alike_are_unclear_and_nothing_is_proposed() -> None:
    setup = scene_setup()
    digitisation, samples = scene(3)
    mixed = samples.astype(np.float64)
    first = round(wiring_steps(3)[2].announce_s * RATE_HZ)
    mean = mixed[:, first:].reshape(3, 2, -1).mean(axis=0)
    mixed[:, first:] = np.tile(mean, (3, 1))
    guide = WiringGuide(setup, digitisation)
    guide.push(Block(mixed.astype(np.int16), 0))
    report = guide.report()
    assert [finding.kind for finding in report.findings] == ["unclear"] * 3
    assert report.channels is None


@settings(max_examples=40)
@given(
    order=st.permutations(range(6)),
    inverted=st.sets(st.integers(0, 5)),
    gain=st.lists(st.floats(0.3, 1.0), min_size=6, max_size=6),
    sign=st.sampled_from([-1, 1]),
)
def test_any_exchange_and_inversion_is_mended_by_the_proposals(
    order: list[int], inverted: set[int], gain: list[float], sign: int
) -> None:
    def unequal(samples: np.ndarray) -> np.ndarray:
        return (samples * np.array(gain)[:, None]).astype(np.int16)

    wires = miswired(order, inverted=sorted(inverted), spoil=unequal)
    setup = scene_setup(radar={"phase_sign": sign})
    report = checked(setup, wires)
    again = rewired(report, setup, wires)
    assert again.is_good, [str(finding) for finding in again.findings]
    assert not again.corrects


def test_the_guide_says_what_to_do_and_when_from_a_ring() -> None:
    setup = scene_setup()
    digitisation, samples = scene(3)
    ring = Ring(6, 8 * int(RATE_HZ), np.int16, digitisation)
    guide = WiringGuide(setup, digitisation, first_index=500)
    heard = []
    ring.append(Block(samples[:, :500], 0))
    for first in range(0, samples.shape[1], 1000):
        part = samples[:, first : first + 1000]
        ring.append(Block(part, first + 500))
        state = guide.poll(ring)
        heard.append((state.number, state.measuring))
        assert state.left_s >= 0.0
    assert guide.is_done
    assert guide.state().step is None
    order = list(dict.fromkeys(heard))
    assert order == [(step, measuring) for step in range(1, 6) for measuring in (False, True)]
    assert guide.report().is_good


def test_samples_lost_during_the_check_are_left_out() -> None:
    setup = scene_setup()
    digitisation, samples = scene(3)
    ring = Ring(6, samples.shape[1], np.int16, digitisation)
    for first in range(0, samples.shape[1], 1000):
        if first != 17_000:
            ring.append(Block(samples[:, first : first + 1000], first))
    guide = WiringGuide(setup, digitisation)
    guide.poll(ring)
    assert guide.report().is_good


def test_the_check_of_three_receivers_is_half_a_minute_and_every_step_has_its_sentence() -> None:
    steps = wiring_steps(3)
    assert steps[-1].end_s == 30.0
    assert [step.receiver for step in steps] == [None, None, 0, 1, 2]
    assert "receiver 3" in steps[-1].instruction
    assert all(step.announce_s < step.start_s < step.end_s for step in steps)


def test_a_recording_of_the_check_can_be_judged_again() -> None:
    from radargui.model.recording import Recording

    setup = scene_setup()
    digitisation, samples = scene(3)
    source = ReplaySource(Recording("check", samples, digitisation), realtime=False, block_s=0.5)
    guide = WiringGuide(setup, source.open())
    source.start()
    while not guide.is_done and (block := source.read()) is not None:
        guide.push(block)
    source.close()
    assert guide.report().is_good
