"""Tissues: one file a geometry, each of which is the section of a case and makes the mesh of its cells."""
