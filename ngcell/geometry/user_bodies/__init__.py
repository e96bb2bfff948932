"""Bodies that a case file describes: one file a shape, each of which is the section of a case and makes its face."""
