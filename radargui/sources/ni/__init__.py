"""The NI device, by a local NI-DAQmx driver or a remote NI gRPC device server.

The package nidaqmx is loaded when it is first needed.
"""
