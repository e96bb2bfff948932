"""What walls do to each other: who is near whom, the gap between them, and what an overlap costs."""
