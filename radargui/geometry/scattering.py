"""Scattering by the tracer; the equations stand in the model, for setups are checked by them."""

from radargui.model.scattering import ConductingSphere, conducting_sphere, scattered_field

__all__ = ["ConductingSphere", "conducting_sphere", "scattered_field"]
