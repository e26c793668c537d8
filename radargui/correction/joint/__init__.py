"""Joint correction: the motion and every receiver's mismatch, estimated together from all channels."""
