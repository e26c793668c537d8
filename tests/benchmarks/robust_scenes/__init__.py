"""Seeded simulations of recordings that nobody here made, written from the physics alone."""
