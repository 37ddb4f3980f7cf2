"""Diagnosis: which known mistake reproduces a backend's numbers."""
