"""What the setup states of antennas, release and wave as unknowns: values with a prior, not the truth (method 4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.assumed import UncertainInput
from radargui.model.gravity import (
    Drag,
    drag_of_sphere,
    expected_gravity,
)
from radargui.model.setup import Setup
from radargui.model.setup_posterior import unknown_inputs
from radargui.physics.path_length import Antennas, place_antennas

_STEP = 1e-3
"""Share of an uncertainty over which derivatives are taken: half a degree of an antenna is nearly linear, this is."""


@dataclass(frozen=True, eq=False)
class SetupUnknowns:
    """Inputs of the setup as unknowns in units of their standard uncertainty, each with the prior N(0, deviation^2).

    Attributes
    ----------
    inputs
        What they are; one that the setup calls exact has the uncertainty to which a laboratory knows it.
    deviation
        1, and next to nothing of what is called exact: its pull shows where it is not, shape (n,).
    by_antenna
        How far each moves the antennas, the transmitter first, m, shape (1 + n_receivers, 3, n).
    by_release
        How far each moves the release, m, shape (3, n).
    by_log_wavenumber
        What each adds to ln K, shape (n,).
    gravity_m_s2, u_gravity_m_s2
        Acceleration of the fall, along -z: the vertical is what the antennas' angles are measured from.
    drag
        Of the sphere in air.
    """

    inputs: tuple[UncertainInput, ...]
    deviation: FloatArray
    by_antenna: FloatArray
    by_release: FloatArray
    by_log_wavenumber: FloatArray
    gravity_m_s2: float
    u_gravity_m_s2: float
    drag: Drag

    @property
    def size(self) -> int:
        """How many there are."""
        return len(self.inputs)

    @staticmethod
    def of(setup: Setup) -> SetupUnknowns:
        """Return the unknowns of a setup: antennas, release, wavelength; what moves no path is none of them."""
        inputs, deviation = unknown_inputs(setup)
        at = _values(setup)
        slopes = [
            [(new - old) / _STEP for new, old in zip(_values(one.moved(setup, _STEP)), at, strict=True)]
            for one in inputs
        ]
        antenna, release, wave = (
            (np.stack(column, axis=-1) for column in zip(*slopes, strict=True))
            if inputs
            else (np.zeros((1 + len(setup.receiver), 3, 0)), np.zeros((3, 0)), np.zeros(0))
        )
        return SetupUnknowns(
            inputs,
            deviation,
            antenna,
            release,
            wave,
            *expected_gravity(setup.site, setup.tracer.density_kg_m3, setup.air.gas),
            drag_of_sphere(setup.tracer.diameter_m, setup.tracer.density_kg_m3, setup.air.gas),
        )

    def antennas(self, at: Antennas, by: FloatArray) -> Antennas:
        """Return antennas moved by so many standard uncertainties, shape (n,)."""
        moved = self.by_antenna @ by
        return Antennas(at.transmitter_m + moved[0], at.receivers_m + moved[1:])


def _values(setup: Setup) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return antennas (1 + n_receivers, 3), release (3,) and ln K of a setup."""
    antennas = place_antennas(setup)
    return (
        np.vstack([antennas.transmitter_m, antennas.receivers_m]),
        np.asarray(setup.tracer.release_position_m),
        np.asarray(-np.log(setup.radar.wavelength_m)),
    )
