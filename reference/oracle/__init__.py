"""The oracle: a verdict on anybody's backend, rung by rung."""
