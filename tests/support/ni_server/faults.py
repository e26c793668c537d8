"""Errors of the stand-in driver, those it makes itself and those a test asks for."""

from __future__ import annotations

from dataclasses import dataclass

TEXTS = {
    -200284: "Some or all of the samples requested have not yet been acquired.",
    -200279: "The application is not able to keep up with the hardware acquisition.",
    -200361: "Onboard device memory overflow.",
    -201003: "Device cannot be accessed.",
    -200220: "Device identifier is invalid.",
    -200170: "Physical channel specified does not exist on this device.",
    -200077: "Requested value is not a supported value for this property.",
    -200081: "Sample rate exceeds the maximum sample rate for the number of channels specified.",
    -50103: "The specified resource is reserved. The operation could not be completed as specified.",
    -200197: "Attribute not supported.",
    -200452: "Specified property is not supported by the device or is not applicable to the task.",
    -89136: "Specified route cannot be satisfied, because the hardware does not support it.",
    -200088: "Task specified is invalid or does not exist.",
    -200478: "Specified operation cannot be performed when there are no channels in the task.",
    -200983: "You only can get the specified property while the task is reserved, committed or while it is running.",
}


class NiError(Exception):
    """An error of the driver on its way to the client."""

    def __init__(self, code: int, samples_read: int | None = None) -> None:
        super().__init__(f"{TEXTS.get(code, 'An error.')}\n\nTask Name: _unnamedTask<0>\n\nStatus Code: {code}")
        self.code = code
        self.samples_read = samples_read


@dataclass
class Fault:
    """An error that a test asked for."""

    rpc: str
    code: int
    after: int  # calls that still work
    times: int  # calls that then fail
    samples_read: int | None


class Faults:
    """What the test asked for and what is due."""

    def __init__(self) -> None:
        self._faults: list[Fault] = []

    def add(self, fault: Fault) -> None:
        """Plan a fault."""
        self._faults.append(fault)

    def check(self, rpc: str) -> None:
        """Raise the fault that is due at this call."""
        for fault in self._faults:
            if fault.rpc != rpc or fault.times == 0:
                continue
            if fault.after > 0:
                fault.after -= 1
                continue
            fault.times -= 1
            raise NiError(fault.code, fault.samples_read)
