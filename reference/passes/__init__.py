"""Algorithms 2, 3 and 4: the passes of a frame, each a pure function of rows."""
