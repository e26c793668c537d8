"""Where samples come from: NI device, simulated scene, replay; one contract."""
