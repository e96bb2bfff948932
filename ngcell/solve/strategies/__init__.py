"""Strategies: how the load path is followed. Each is one file, with its section of a case."""
