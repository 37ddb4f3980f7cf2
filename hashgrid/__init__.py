"""Reservoirs kept in the cells of a hashed world-space grid.

Keys and cells of the grid, light reservoirs for every vertex of a path, and path
reservoirs for every cell.  It stands on ``extensions`` and ``reference``; it and
``gradient_domain`` do not import each other.
"""
