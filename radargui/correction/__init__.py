"""Removal of IQ mismatch: published, ellipse, none."""
