"""Backends: Python objects, programs and folders of files, each kept at a distance."""
