"""The report of a verdict: for programs, for the terminal, and as a page."""
