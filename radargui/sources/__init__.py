"""Sources of samples: NI device, simulated scene and replay, all with one contract."""
