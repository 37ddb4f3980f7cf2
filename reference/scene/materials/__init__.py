"""How surfaces scatter light: one kind a file, and a table that picks the kind."""
