"""What continuous integration reads of a verdict: JUnit, SARIF, what is new in it."""
