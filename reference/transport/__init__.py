"""The plain estimator: rays, direct light, and the path tracer."""
