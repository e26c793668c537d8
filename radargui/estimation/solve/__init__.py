"""Unknowns, normal matrix, minimum, priors."""
