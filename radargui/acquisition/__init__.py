"""The threads of an acquisition: reader, ring, recorder, live track, health."""
