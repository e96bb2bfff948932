"""The documentation as a site: pages of `docs`, and pages made from the schema, the commands, the names and by running."""
