"""Loads that act on boundaries and in bodies, one file each, and the terms of the energy that hold them."""
