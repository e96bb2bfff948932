"""Cohesion: the laws of traction over opening, one file a law, and the bonds that follow them."""
