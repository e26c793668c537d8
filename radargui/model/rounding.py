"""Write a value with its uncertainty as metrology does: u with two digits, the value to the same decimal."""

import math
from decimal import ROUND_HALF_EVEN, Context, Decimal

UNKNOWN = "–"
COVERAGE = 2.0
"""Standard uncertainties that bars and bands reach to either side, and within which figures agree (GUM 6.3.3)."""
_SIGNIFICANT = 2  # digits of an uncertainty: two at the most are of use (JCGM 100, 7.2.6)
_SHOWN, _WIDE = (Context(prec=digits, rounding=ROUND_HALF_EVEN) for digits in (_SIGNIFICANT, 1000))
"""All digits of two doubles fit into 1000: 309 before the point, 325 behind it."""


def quantity(value: float | None, u: float | None, unit: str = "", scale: float = 1.0) -> str:
    """Return "0.8123 ± 0.0012": u with two significant digits, the value to the same decimal (GUM 7.2.6).

    Parameters
    ----------
    value
        None or NaN gives a dash.
    u
        Standard uncertainty; None, NaN, zero or below: the value stands alone with four significant digits.
    unit
        Written behind, where there is a value.
    scale
        Factor from the value's unit to the one shown: 1e3 from m to mm.
    """
    if value is None or not math.isfinite(value):
        return UNKNOWN
    tail = f" {unit}" if unit else ""
    if u is None or not math.isfinite(u) or u <= 0.0:
        return plain(value, scale=scale) + tail
    # rounded before its last place is told, for that may add a digit: 0.0996 shows 0.10, not 0.100
    last = _SHOWN.create_decimal(repr(float(u * scale))).adjusted() - _SIGNIFICANT + 1
    both = f"{_at(value * scale, last)} ± {_at(u * scale, last)}"
    return f"({both}){tail}" if tail else both


def concise(value: float | None, u: float | None, unit: str = "", scale: float = 1.0) -> str:
    """Return "0.8123(12)", the digits of u below the last ones of the value (GUM 7.2.2); see `quantity`.

    A u of one and more keeps its decimal point, "12.3(1.2)": what stands in the brackets is then read one way only.
    """
    shown, plus_minus, own = quantity(value, u, scale=scale).partition(" ± ")
    digits = own if own[:1].strip("0") else own.replace(".", "").lstrip("0")
    return f"{shown}{f'({digits})' if plus_minus else ''}{f' {unit}' if unit and shown != UNKNOWN else ''}"


def alone(value: float | None, u: float | None, scale: float = 1.0, *, signed: bool = False) -> str:
    """Return a value to the decimal that `quantity` gives it, without the uncertainty beside it.

    Parameters
    ----------
    value, u, scale
        See `quantity`.
    signed
        Whether to write a plus, for differences; what rounds to nothing has no sign.
    """
    text = quantity(value, u, scale=scale).partition(" ± ")[0]
    return f"+{text}" if signed and text != UNKNOWN and float(text) > 0.0 else text


def to_digits_of_u(value: float | None, u: float | None, scale: float = 1.0) -> str:
    """Return what scatters, to the decimal that a value with this u has: u leaves further digits open.

    What rounds to nothing there is below its last place, "< 0.00001". Without u two digits are significant.
    """
    if value is None or not u:
        return plain(value, _SIGNIFICANT, scale=scale)
    shown = alone(value, u, scale)
    return f"< {shown[:-1]}1" if float(shown) == 0.0 and value > 0.0 else shown


def with_sign(value: float, places: int) -> str:
    """Return a number with so many decimals and its sign; what rounds to nothing has none."""
    text = f"{value:+z.{places}f}"
    return text if float(text) else text[1:]


def plain(value: float | None, digits: int = 4, unit: str = "", scale: float = 1.0) -> str:
    """Return a number alone with so many significant digits, never in powers of ten between 1e-5 and 1e6."""
    if value is None or not math.isfinite(value):
        return UNKNOWN
    scaled = float(value) * scale
    tail = f" {unit}" if unit else ""
    if scaled == 0.0:
        return "0" + tail
    if not 1e-5 <= abs(scaled) < 1e6:
        return f"{scaled:.{digits - 1}e}{tail}"
    exponent = math.floor(math.log10(abs(scaled)))
    return _at(scaled, exponent - digits + 1) + tail


def _at(value: float, last: int) -> str:
    """Return a number with its last digit at an exponent of ten."""
    # the shortest decimal of the number: a binary rest must not decide how a 5 is rounded
    rounded = Decimal(repr(float(value))).quantize(Decimal(1).scaleb(last), context=_WIDE)
    # what rounds to nothing has no sign
    return f"{abs(rounded) if rounded == 0 else rounded:f}"
