"""Unknowns, priors, normal matrix and minimum of the joint problem."""
