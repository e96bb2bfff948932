"""Constitutive laws of solids: one file a law, each of which is the section of a case and its realisation."""
