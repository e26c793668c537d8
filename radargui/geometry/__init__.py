"""Path lengths, the matrix T, the exact bistatic solution, mirrored antennas."""
