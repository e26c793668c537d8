"""Words as people read them: a number of things, a sentence."""


def counted(count: int, noun: str) -> str:
    """Return "1 run", "2 runs"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def sentence(text: str) -> str:
    """Return words with a capital and a full stop; a symbol of one letter stays as it is: U is no u."""
    first = text[:1] if text[1:2] == " " else text[:1].upper()
    return f"{first}{text[1:].rstrip('.')}."
