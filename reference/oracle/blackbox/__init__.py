"""Renderers that only give pictures."""
