"""Figures of the grid and of what is kept in its cells."""
