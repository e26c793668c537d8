"""Measure once what every correction starts from: noise, hum, rest, onset, motion, lines, faulty channels.

Method 2, Before every correction.
"""
