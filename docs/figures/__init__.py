"""The figures of the papers and of the documentation, measured and drawn."""
