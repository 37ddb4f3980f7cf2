"""Algorithm 1 and Equations 4 to 11: reservoirs, targets, shift and weights."""
