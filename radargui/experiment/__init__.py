"""Arm, record, process and save: what the window and the command line both call."""
