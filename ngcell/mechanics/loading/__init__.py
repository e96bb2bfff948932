"""Loads of tissues: each is one file, a section of a case that says what it moves and how."""
