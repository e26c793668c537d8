"""What counts populations: scenes on disk, one process a version, scores, rates with their intervals."""
