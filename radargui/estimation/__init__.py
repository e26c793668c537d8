"""Motion and mismatch estimated from all channels together: adaptive, joint."""
