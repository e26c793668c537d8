"""The world that a radar watches, from physics alone: fields, motions, front ends; no code shared with the estimate."""
