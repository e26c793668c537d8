"""Hostile input: damaged files of every kind, read in a process with little memory that is watched."""
