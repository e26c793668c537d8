"""Drops with one disturbance of a real room each, from the physics alone."""
