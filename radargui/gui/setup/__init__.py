"""The forms of the setup: hardware, processing, antennas."""
