"""Levels of the ladder, the cheap ones first."""
