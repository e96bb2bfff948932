"""Loads that act on boundaries and in bodies, one file each, and the term of the energy that holds them all."""
