"""Fast plots: axes, decimation, ranges."""
