"""What lumens hold: nothing, a pressure, a solid or a fluid."""
