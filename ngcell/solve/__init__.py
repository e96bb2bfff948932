"""Minimisation of an energy, load stepping and the two strategies; knows problems only by protocol."""
