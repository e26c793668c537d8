"""What a solution says: samples, flights, constants."""
