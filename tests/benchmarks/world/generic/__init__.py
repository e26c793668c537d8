"""Motions before receivers whose bias and amplitude are smooth in position, or that mirrors disturb."""
