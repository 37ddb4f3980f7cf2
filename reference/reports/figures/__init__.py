"""Figures: how they look, which numbers stand beside them, and where they are."""
