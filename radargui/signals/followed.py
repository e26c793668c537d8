"""Follow one or two receivers, each by its own Doppler line, because they determine no position."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.signals.doppler import ALONE, Doppler, measure_doppler
from radargui.signals.rows import pairs_of
from radargui.signals.segment import Motion

if TYPE_CHECKING:
    from radargui.signals.echo import Echo

FILLED_SHARE, FILL_ROUNDS = 0.003, 4
"""Share of clipped samples that moves the front end by its u, and rounds after which a fifth of them does not."""
CLIPPED_U = 0.25
"""Uncertainty of ln gain that filled samples leave, times their share (`bench robust`, kind clipped)."""
MIN_LED = 0.12
"""Share of a record that an echo under the noise must lead in to be a motion: as in `MIN_KNOWN` of the path."""


def follow_receiver(
    pair_v: FloatArray, usable: BoolArray, rate_hz: float, noise_v: FloatArray, lines_hz: tuple[float, ...]
) -> tuple[Doppler, Echo | None]:
    """Return the lines and the echo of one receiver; clipped samples are filled with what the echo shows there."""
    # half a second to load, and only one or two receivers need it
    from radargui.signals.echo import follow_echo

    share, filled_v, settings, before = float((~usable).mean()), pair_v, ALONE, None
    rounds = FILL_ROUNDS if share > FILLED_SHARE else 0
    while True:
        doppler = measure_doppler(filled_v, rate_hz, noise_v, settings).without_mains(lines_hz)
        echo = follow_echo(filled_v, usable, noise_v, doppler)
        if echo is not None and before is not None:
            echo = replace(echo, front_end=echo.front_end.with_change_since(before, CLIPPED_U * share))
        if echo is None or rounds == 0:
            return doppler, echo
        # as it was, but for what was clipped
        settings = replace(ALONE, lengths_s=(doppler.size / rate_hz,))
        filled_v, before, rounds = np.where(usable, pair_v, echo.shown_v), echo.front_end, rounds - 1


def steady_motion(
    volts: FloatArray, usable: BoolArray, rate_hz: float, noise_v: FloatArray, lines_hz: tuple[float, ...]
) -> Motion | None:
    """Return the motion of a target too weak to shake the voltages, but whose line one or two receivers show."""
    pairs = pairs_of(volts)
    if len(pairs) >= MIN_RECEIVERS:
        return None
    for pair in pairs:
        _, echo = follow_receiver(volts[pair], usable[pair], rate_hz, noise_v[pair], lines_hz)
        if echo is not None and echo.leads.mean() > MIN_LED:
            return Motion(0, volts.shape[1], 0.0)
    return None
