"""Choose the model by its evidence: breaks, floor, walls, lengths of the maps."""
