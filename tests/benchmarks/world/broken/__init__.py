"""Drops with a broken channel, and channels in which there is no sphere."""
