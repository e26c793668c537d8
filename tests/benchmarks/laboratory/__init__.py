"""A laboratory of vector fields with known truth, from the physics alone: no code shared with the estimate."""
