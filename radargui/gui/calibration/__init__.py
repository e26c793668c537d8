"""Calibration in the window: the guided dialog, its result, and what leads to it."""
