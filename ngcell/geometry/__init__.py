"""Scene to mesh: separate bodies, their named boundaries, and which walls face each other."""
