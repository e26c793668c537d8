"""Values with units, settings, errors: what every other package speaks in."""
