"""Coefficient of restitution with uncertainty, floor normal, free fall."""
