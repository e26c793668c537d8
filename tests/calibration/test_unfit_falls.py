"""Of many drops some may be none, or pushed: these are left out, and told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from benchmarks.scoring.calibration_scenes import dropped, laboratory
from support.calibrations import calibration_of
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.calibration.calibrate import Calibrated, calibrate
from radargui.calibration.rough_fit import KnownRecording, UnfitFallError, rough_fit
from radargui.calibration.unknowns import USUAL
from radargui.model.errors import ProcessingError
from radargui.model.setup import Setup

RATE = {"rate_hz": 2000.0}


def recorded(setup: Setup, names: Sequence[str]) -> list[KnownRecording]:
    """Return the same recording under some names, as drops."""
    recording, _ = simulate_recording(setup)
    place = setup.tracer.release_position_m
    return [KnownRecording(recording, name, name, None, place) for name in names]


def test_which_recording_is_no_fall_is_told() -> None:
    setup = simulated_setup(daq=RATE)
    circle = recorded(simulated_setup(daq=RATE, scene="circle"), ["second"])
    given = [*recorded(setup, ["first"]), *circle, *recorded(setup, ["third"])]
    with pytest.raises(UnfitFallError, match="no free fall") as caught:
        rough_fit(given, setup, USUAL)
    assert caught.value.number == 1


@pytest.mark.slow
def test_swapped_receivers_are_named_by_drops_alone_though_their_paths_were_followed_with_wrong_antennas() -> None:
    # fringes that a wrong geometry foretold made a mirror image fit better
    lab = laboratory(3050610, snr_db=36.0, rate_hz=5000.0)
    given = [
        KnownRecording(dropped(lab, n, n % 3).recording, f"drop-{n}", "", None, lab.places_m[n % 3]) for n in range(6)
    ]
    first, second, third = lab.setup.receiver
    swapped = lab.setup.model_copy(update={"receiver": (third, second, first)})
    with pytest.raises(ProcessingError, match="they do where receivers 1 and 3 are swapped"):
        rough_fit(given, swapped, USUAL)


@pytest.mark.parametrize("n_unfit", [0, 3, 4])
def test_some_unfit_drops_are_left_out_and_told_and_not_many(n_unfit: int) -> None:
    setup = simulated_setup(daq=RATE)
    given = recorded(setup, [f"drop-{n}" for n in range(1, 10)])
    unfit, tried = {f"drop-{n}" for n in range(4, 4 + n_unfit)}, []

    def fitted(recordings: Sequence[KnownRecording], setup: Setup, *_: Any) -> Calibrated:
        tried.append([one.name for one in recordings])
        for number, one in enumerate(recordings):
            if one.name in unfit:
                raise UnfitFallError.of(number, ProcessingError(f"{one.name}: pushed", remedy="Leave it out."))
        return Calibrated(calibration_of(setup), setup, None)  # type: ignore[arg-type]

    shares: list[float] = []
    if n_unfit > 3:
        with pytest.raises(UnfitFallError, match="drop-4: pushed"):
            calibrate(given, setup, progress=shares.append, fit=fitted)
        return
    found = calibrate(given, setup, progress=shares.append, fit=fitted)
    assert tried[-1] == [one.name for one in given if one.name not in unfit]
    told = [note for note in found.calibration.notes if note.startswith("left out")]
    assert told == [f"left out: {name}: pushed" for name in sorted(unfit)]
    assert max(shares) == 1.0
