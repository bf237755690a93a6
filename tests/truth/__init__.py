"""How this engine is judged, row by row: on systems that nobody here invented, and against itself."""
