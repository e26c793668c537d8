"""Samples to results, offline and live."""
