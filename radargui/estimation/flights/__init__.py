"""A drop by its flights: motion, antennas and floor as few unknowns of all channels (method 4, Flights first)."""
