"""Sessions in the window: found, opened, recovered, imported, exported, processed again."""
