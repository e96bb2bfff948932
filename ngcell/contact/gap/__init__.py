"""The normal gap of contact pairs as a function of the unknowns, and its derivatives."""
