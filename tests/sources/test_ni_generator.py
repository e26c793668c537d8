"""The generator of benchmarks streams what it promises from a process of its own."""

from __future__ import annotations

import numpy as np
from support.changed import changed
from support.ni_generator import generator

from radargui.model.setup import read_setup
from radargui.sources.ni.source import NiSource
from radargui.sources.simulated.model import SimulatedRadar
from radargui.system.resources import default_setup_path


def test_the_generator_streams_the_repeated_scene_bit_for_bit_and_reports_its_own_time() -> None:
    setup = changed(
        read_setup(default_setup_path()),
        daq={"rate_hz": 10_000.0, "channel_skew_s": 15e-6},
        simulation={"rest_s": 0.02, "settle_s": 0.0},
    )
    with generator(setup) as stream:
        source = NiSource(stream.setup)
        digitisation = source.open()
        source.start()
        blocks = [source.read() for _ in range(3)]
        source.close()
        period = stream.about["period_samples"]
    samples = np.concatenate([block.samples for block in blocks if block is not None], axis=1)
    assert samples.shape == (6, 600)
    assert period % stream.about["block_samples"] == 0
    np.testing.assert_array_equal(samples, SimulatedRadar(setup, repeat=True).samples(0, 600))
    assert digitisation.device.startswith("DAQPad-6015")
    assert stream.report["samples"] >= 600
    assert stream.report["overwritten"] == 0
    assert stream.report["cpu_share"] == stream.report["cpu_s"] / stream.report["streamed_s"]
    assert len(stream.report["started_at_s"]) == 1
