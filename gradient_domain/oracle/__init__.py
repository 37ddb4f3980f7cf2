"""Differences of pixels and their images: the part of the contract, and its judges."""
