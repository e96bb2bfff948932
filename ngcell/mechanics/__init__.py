"""Unknowns, stored energies and ties: what a state of the bodies costs."""
