"""What keeps walls apart and together: penalty, mortar method, cohesion."""
