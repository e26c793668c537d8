"""The NI device: local NI-DAQmx driver or remote NI gRPC device server; nidaqmx is loaded when first needed."""

from radargui.sources.ni.discovery import NiDevice, TerminalChoice, driver_version, find_devices
from radargui.sources.ni.source import NiSource, SetupCheck, check_setup

__all__ = ["NiDevice", "NiSource", "SetupCheck", "TerminalChoice", "check_setup", "driver_version", "find_devices"]
