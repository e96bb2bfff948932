"""Rupture of walls: how near each is to its strength, at which load it would rupture, and how each cell ends."""
