"""Arm, record, process, save: what the window and the command line both call."""
