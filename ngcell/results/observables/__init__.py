"""Observables: numbers and fields that a case, or a script, asks for besides those that every run has."""
