"""Passes of the hash grid and of what its cells keep, as a part of the contract."""
