"""What is said of a run: an ordered list of functions from the evidence to a finding, one file a family."""
