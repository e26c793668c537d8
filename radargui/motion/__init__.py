"""Impacts and sharp minima of a height."""
