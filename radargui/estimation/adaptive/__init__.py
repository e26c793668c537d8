"""Adaptive correction: each receiver's circle with a centre and a radius that are functions of position."""
