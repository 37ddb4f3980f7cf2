"""Figures of this floor's methods."""
