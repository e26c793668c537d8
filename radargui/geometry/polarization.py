"""Polarisation of the antennas; the equations stand in the model, for setups are checked by them."""

from radargui.model.polarization import (
    received_direction,
    strongest_polarization_deg,
    transmitted_direction,
    transverse_axes,
)

__all__ = ["received_direction", "strongest_polarization_deg", "transmitted_direction", "transverse_axes"]
