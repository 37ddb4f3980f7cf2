"""The oracle: a verdict on anybody's backend, level by level."""
