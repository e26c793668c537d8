"""Words as people read them: a number of things, a share, a time, a sentence."""

from datetime import datetime


def counted(count: int, noun: str) -> str:
    """Return "1 run", "2 runs"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def sentence(text: str) -> str:
    """Return words with a capital and a full stop; a symbol of one letter stays as it is: U is no u."""
    first = text[:1] if text[1:2] == " " else text[:1].upper()
    return f"{first}{text[1:].rstrip('.')}."


def percent(share: float) -> str:
    """Return "25 %": a share of 1 in whole per cent, with a space as before every unit (SI Brochure, 5.4.7)."""
    return f"{100.0 * share:.0f} %"


def written_time(at: str, how: str, otherwise: str) -> str:
    """Return a time in ISO 8601 as `strftime` writes it; what is none is said `otherwise`."""
    try:
        return datetime.fromisoformat(at).strftime(how)
    except ValueError:
        return otherwise
