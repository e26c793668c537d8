"""Removal of IQ mismatch: published, ellipse, adaptive, joint."""
