"""Pure functions on arrays: equilibria and certificates."""
