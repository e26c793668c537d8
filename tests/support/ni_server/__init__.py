"""A stand-in NI gRPC device server: the real nidaqmx client runs against it without any hardware.

with serve(recording) as server:
    ...  # daq.remote = server.address
"""

from support.ni_server.devices import StandInDevice, daqpad_6015, delta_sigma, digital_only, usb_6356
from support.ni_server.pace import AsFastAsPossible, ByHand, RealTime
from support.ni_server.server import NiServer, serve

__all__ = [
    "AsFastAsPossible",
    "ByHand",
    "NiServer",
    "RealTime",
    "StandInDevice",
    "daqpad_6015",
    "delta_sigma",
    "digital_only",
    "serve",
    "usb_6356",
]
