"""Setups that state the laboratory wrongly, as people do: the world stays true, the drop and its truth too."""
