"""Passes of the extensions, as parts of the oracle's contract."""
