"""Which points of different bodies are closest to each other, and over which parts walls face each other."""
