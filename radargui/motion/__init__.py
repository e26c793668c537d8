"""Motion segment, rest, impacts, flights."""
