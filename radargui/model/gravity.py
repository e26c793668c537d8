"""Gravity where nobody has told its value at the place."""

from __future__ import annotations

NOMINAL_GRAVITY_M_S2 = 9.81
"""Free fall at sea level in 49 degrees latitude (WGS 84); 9.780 at the equator to 9.832 at the poles.

Limits and starting values use it; where g is a result it is measured. Standard gravity (9.80665) is no better a guess.
"""
