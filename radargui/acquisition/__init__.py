"""The worker: reader, ring, trigger, recorder, health, live."""
