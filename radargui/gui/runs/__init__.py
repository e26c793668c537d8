"""The list of runs and the result of one."""
