"""Samples to results: the chain."""
