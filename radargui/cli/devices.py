"""`radargui devices`: the NI devices that can be reached."""

from __future__ import annotations

import typer

from radargui.cli.console import show_table
from radargui.sources.ni.device import NiDevice
from radargui.sources.ni.discovery import find_devices


def list_devices(remote: str | None) -> int:
    """Print one line a device and return the exit status.

    Raises
    ------
    DeviceError
        The driver is missing, or the device server cannot be reached.
    """
    found = find_devices(remote)
    place = remote or "this computer"
    if not found:
        typer.echo(f"No NI device at {place}. Plug it in, switch it on and look whether NI MAX shows it.")
        return 0
    show_table(
        ("name", "product", "serial number", "analog inputs", "fastest", "range", "sampling"),
        [_row(device) for device in found],
    )
    return 0


def _row(device: NiDevice) -> tuple[str, ...]:
    rate = device.max_rate_multi_hz or device.max_rate_single_hz
    widest = max((high for _, high in device.ranges_v), default=None)
    notes = [note for note, true in (("simulated", device.simulated), ("not connected", not device.connected)) if true]
    return (
        device.name,
        " ".join([device.product_type or "unknown", *(f"({note})" for note in notes)]),
        device.serial_number or "-",
        str(len(device.channels)),
        f"{rate / 1000:g} kS/s {'each' if device.simultaneous else 'in all'}" if rate else "-",
        f"±{widest:g} V" if widest else "-",
        "simultaneous" if device.simultaneous else "multiplexed",
    )
