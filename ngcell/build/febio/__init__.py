"""A planar tissue as a FEBio deck: `layer` makes the mesh, `deck` says what is in it, `xml` writes it down."""
