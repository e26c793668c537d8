"""A target before a radar with one receiver."""
