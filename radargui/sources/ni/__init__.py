"""The NI device: local NI-DAQmx driver or remote NI gRPC device server; nidaqmx is loaded when first needed."""
