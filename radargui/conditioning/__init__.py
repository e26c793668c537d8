"""What every correction starts from, found once: gaps, clipping, noise, hum, rest, onset, motion, skew."""
