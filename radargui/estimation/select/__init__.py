"""Which model: breaks, floor, walls, lengths; the evidence decides."""
