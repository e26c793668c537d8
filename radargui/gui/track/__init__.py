"""The track in space and against time."""
