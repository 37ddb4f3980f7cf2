"""Differences of neighbouring pixels, estimated by resampling, and the image from them.

The domain of a pair of pixels, its inner and outer shift, the split into a positive and
a negative part, reuse along edges, and Poisson reconstruction.  It stands on
``extensions`` and ``reference``; it and ``hashgrid`` do not import each other.
"""
