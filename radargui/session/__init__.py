"""Sessions: what is kept and found again."""
