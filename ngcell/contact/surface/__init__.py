"""The facets that may touch: edges in the plane, faces in three dimensions, as arrays."""
