"""What is said of flights that bend: how much, and by what likely, where nothing else names a cause."""

from collections.abc import Iterable

_GUESS = " likely a reflector that is not in the model, or a setup that is wrong by more than it says;"
_REMEDY = ": cover what reflects within a metre, measure the antennas' places again"


def bent_flights(chi_square: float, expected: int, widening: float) -> str:
    """Return the sentence, with a guess at the cause.

    Parameters
    ----------
    chi_square, expected
        Of the free motion against its flights, and its degrees of freedom.
    widening
        What the uncertainties were multiplied by.
    """
    return (
        "the flights bend by more than what is known can make them "
        f"(chi-square {chi_square:.0f} of {expected}):{_GUESS} the uncertainties of track, e and g were widened "
        f"{widening:.1f} times{_REMEDY}"
    )


def without_guess(warnings: Iterable[str]) -> list[str]:
    """Return sentences without that guess: for where another one names the cause."""
    return [one.replace(_GUESS, "").replace(_REMEDY, "") for one in warnings]
