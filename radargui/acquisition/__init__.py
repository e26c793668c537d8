"""The threads: reader, ring, recorder, live, health."""
