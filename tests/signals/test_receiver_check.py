"""What is said of a pair of channels that is no receiver."""

import numpy as np
import pytest
from benchmarks.world.draw import draw
from benchmarks.world.scene import make_record
from support.words import words

from radargui.signals.condition import condition
from radargui.signals.conditioned import Conditioned
from radargui.signals.doppler import measure_doppler
from radargui.signals.receiver_check import check_receiver

RATE_HZ = 10000.0
TURNS = 150.0 * np.arange(20000) / RATE_HZ


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("strength", "said"), [(0.0, "white noise and nothing else"), (0.35, "")])
def test_a_receiver_with_noise_alone_is_told_from_one_with_an_echo_below_its_noise(
    seed: int, strength: float, said: str
) -> None:
    noise = np.random.default_rng(seed).normal(size=(2, TURNS.size))
    pair_v = noise + strength * np.stack([np.cos(2 * np.pi * TURNS), np.sin(2 * np.pi * TURNS)])
    doppler = measure_doppler(pair_v, RATE_HZ, np.ones(2))
    found = check_receiver(doppler, pair_v, np.ones(2), np.ones(pair_v.shape, dtype=np.bool_))
    assert said in words(found)
    assert (found is not None) == bool(said)


def test_a_hand_that_trembles_while_it_holds_judges_no_pair() -> None:
    # to and fro by 0.1 mm: I and Q move along a short arc, together
    record = make_record(draw(1206, "exact", motion="hand"))
    found = condition(record.recording, record.scene.setup)
    assert isinstance(found, Conditioned)
    assert found.faults == (None, None, None)
