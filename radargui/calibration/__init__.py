"""Calibrate the antennas from known motions and from drops.

Method 6, Calibration.
"""
