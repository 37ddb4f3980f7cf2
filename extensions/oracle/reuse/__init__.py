"""Reuse of whole samples: the part of the contract, and its judges."""
