"""Coefficient of restitution with uncertainty, free fall."""
