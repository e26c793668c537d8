"""Read a solution: samples, flights, velocities, responses to the setup."""
