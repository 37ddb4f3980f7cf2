"""Reservoirs in bits: the 48 bytes of the paper, and three public layouts beside them.

Unlike the other kernels these take floats alone, of 16 to 64 bits: bits are their end.
"""
