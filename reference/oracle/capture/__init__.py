"""Captures: the buffers of an engine's own frames, as arrays in the contract's words.

An engineer copies buffers of some frames into a folder.  ``capture.toml`` says of each
buffer where it lies, how its bits are laid out and what its numbers are.
"""
