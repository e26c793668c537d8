"""The words of all errors of an NI device, its driver and the way to it; they stand in resources/ni/errors.toml."""

from radargui.model.errors import DeviceError
from radargui.model.resources import resource_table

WORDS = resource_table("ni/errors")


def device_error(name: str, /, **facts: object) -> DeviceError:
    """Return the error of a name, with facts in the places that its words leave for them."""
    words = WORDS[name]
    fact, remedy = (words.get(part, "").format_map(facts) for part in ("fact", "remedy"))
    return DeviceError(fact, reasons=words.get("reasons", ()), remedy=remedy)
