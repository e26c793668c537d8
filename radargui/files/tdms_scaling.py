"""TDMS scaling: the chain of linear and polynomial scales of a channel as one polynomial of its codes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

_RAW = 0xFFFFFFFF
"""Input of a scale that takes the samples as they are stored."""
_HIGHEST_DEGREE = 12
"""NI devices store polynomials of degree 1 to 3; linear scales chained to one do not raise it. Chosen by hand."""
_MOST_SCALES = 64
"""A chain of that many is damage; each costs a step. Chosen by hand."""
_KINDS = frozenset(
    ["Linear", "Polynomial", "RTD", "Strain", "Table", "Thermistor", "Thermocouple", "Add", "Subtract", "AdvancedAPI"],
)
_LINEAR, _POLYNOMIAL = "Linear", "Polynomial"


def is_sound(properties: Mapping[str, Any]) -> bool:
    """Return whether the scales of a channel can be true: not too many, each of a kind that TDMS knows.

    The reading library leaves out a scale of an unknown kind, which would make codes pass for volts.
    """
    count = properties.get("NI_Number_Of_Scales", 0)
    if not isinstance(count, int | np.integer) or not 0 <= count <= _MOST_SCALES:
        return False
    kinds = [properties.get(f"NI_Scale[{index}]_Scale_Type") for index in range(int(count))]
    return not kinds or (kinds[-1] is not None and all(kind is None or kind in _KINDS for kind in kinds))


def code_polynomial(properties: Mapping[str, Any]) -> tuple[float, ...] | None:
    """Return c_k of value = sum c_k code^k, or None where the scaling is not a polynomial.

    Scale i takes the output of another scale or the codes; the last scale gives the values. A scale without
    properties is the device's own and passes the codes on.
    """
    if not is_sound(properties):
        return None
    outputs: dict[int, np.ndarray[Any, np.dtype[np.float64]]] = {}
    last = np.array([0.0, 1.0])
    for index in range(int(properties.get("NI_Number_Of_Scales", 0))):
        prefix = f"NI_Scale[{index}]"
        kind = properties.get(f"{prefix}_Scale_Type")
        if kind is None:
            outputs[index] = np.array([0.0, 1.0])
            continue
        source = properties.get(f"{prefix}_{kind}_Input_Source", _RAW)
        inner = np.array([0.0, 1.0]) if source == _RAW else outputs.get(int(source))
        outer = _coefficients(properties, prefix, kind)
        if inner is None or outer is None or (len(outer) - 1) * (len(inner) - 1) > _HIGHEST_DEGREE:
            return None
        last = outputs[index] = np.asarray(Polynomial(outer)(Polynomial(inner)).coef, dtype=np.float64)
    return tuple(last.tolist()) if np.isfinite(last).all() else None


def _coefficients(properties: Mapping[str, Any], prefix: str, kind: str) -> list[float] | None:
    if kind == _LINEAR:
        keys = [f"{prefix}_Linear_Y_Intercept", f"{prefix}_Linear_Slope"]
    elif kind == _POLYNOMIAL:
        count = properties.get(f"{prefix}_Polynomial_Coefficients_Size", 4)
        if not 1 <= int(count) <= _HIGHEST_DEGREE + 1:
            return None
        keys = [f"{prefix}_Polynomial_Coefficients[{order}]" for order in range(int(count))]
    else:
        return None
    return [float(properties[key]) for key in keys] if all(key in properties for key in keys) else None
