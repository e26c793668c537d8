"""Seeded scenes with known truth for the accuracy benchmark, independent of every estimator."""
