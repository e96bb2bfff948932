"""What lumens hold: each is one file, a section of a case that says which terms it adds."""
