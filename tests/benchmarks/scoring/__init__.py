"""How far estimates are from the truth of their scenes: scores, tables, and what is true of the real recordings."""
