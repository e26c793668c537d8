"""The wiring check: the guide across the room, and what it found."""
