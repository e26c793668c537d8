"""Live IQ: voltages against time and the IQ plane."""
