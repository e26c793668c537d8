"""What the tracer says about the antennas: known trajectories, falls, and the fit of a setup to them."""
