"""What walls do to each other. Four rooms, each importing only those named before it:

surface
    The facets that may touch: edges in the plane, faces in three dimensions.
pairing
    Which points of different bodies are closest to each other.
gap
    The normal gap of a pair as a function of the unknowns, and its derivatives.
methods
    The energies that keep walls apart, and those that hold them together: penalty, mortar method, cohesion.

The dimension is asked once, where a surface is made. Each room has an algorithm for edges and one for faces where they
differ, and chooses by the class of the surface.
"""
