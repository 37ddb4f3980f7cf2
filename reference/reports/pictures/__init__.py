"""The report of a verdict on pictures: for programs, for the terminal, as a page."""
