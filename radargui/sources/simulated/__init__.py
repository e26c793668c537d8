"""The simulated source: spherical waves to a moving tracer and back, mismatch, noise, converter.

From motion to samples: `scene` (a motion between two rests; drop and fall onto a bed are `fall`) -> `waves`
(antennas and their images in floor and walls; `exchange` adds what sphere and floor send to and fro) -> `mismatch`
(what moves with the tracer; mixers) -> `noise` -> the converter of `mismatch`; `model` joins them. A new motion is one
more trajectory, another disturbance one more term.
"""
